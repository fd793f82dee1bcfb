#include "stereo/command/stereo_files.h"

#include "base/image/png.h"
#include "stereo/pictures.h"

namespace rangegrasp::cli {

void WriteStereoPictures(const stereo::Reconstruction& made, const std::filesystem::path& folder) {
  image::WritePng(folder / "rectified.png", stereo::RectifiedPicture(made.rectified));
  image::WritePng(folder / "disparity.png", stereo::DisparityPicture(made.disparity));
  image::WritePng(folder / "disparity16.png", stereo::EncodeDisparity(made.disparity));
}

}  // namespace rangegrasp::cli
