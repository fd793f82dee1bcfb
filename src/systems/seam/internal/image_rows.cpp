#include "seam/internal/image_rows.h"

#include <fmt/format.h>

#include <span>

#include "base/error.h"
#include "base/image/png.h"
#include "seam/image/pgm.h"
#include "seam/image/tiff.h"
#include "seam/internal/height.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;

bool IsTiff(const std::string& ending) { return ending == ".tif" || ending == ".tiff"; }

template <typename Pixel>
RawRow RowOf(std::span<const Pixel> levels, std::size_t number, const HeightOf& height_of) {
  RawRow row;
  row.row = row.line = number;
  row.width = levels.size();
  row.height_m.reserve(levels.size());
  std::string fault;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto level = static_cast<double>(levels[i]);
    row.height_m.push_back(height_of(level, fault));
    if (fault.empty()) continue;
    throw InputError(
        fmt::format("row {}, column {}: level {:.7g} {}", number, i + 1, level, fault));
  }
  return row;
}

template <typename Pixel>
std::vector<RawRow> RowsOf(const image::Grey<Pixel>& image, const HeightScale& scale,
                           const ProfileFileOptions& options) {
  const auto columns = static_cast<std::size_t>(image.width);
  if (options.columns != 0 && image.width != options.columns) {
    throw InputError(WidthFault(columns, options.columns));
  }
  const HeightOf height_of(options, scale);
  std::vector<RawRow> rows;
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row) {
    const auto levels = std::span(image.grey).subspan(row * columns, columns);
    rows.push_back(RowOf<Pixel>(levels, row + 1, height_of));
  }
  return rows;
}

std::vector<RawRow> RowsOfTiff(const std::string& bytes, const ProfileFileOptions& options) {
  const image::Tiff tiff = image::DecodeTiff(bytes);
  HeightScale scale = options.grey;
  if (tiff.pixel == image::TiffPixel::kSigned16) scale = options.signed_grey;
  if (tiff.pixel == image::TiffPixel::kFloat32) scale = options.real;
  // As the file holds them: -999.9999 is no float.
  for (double& none : scale.no_values) none = static_cast<float>(none);
  return RowsOf(tiff.picture, scale, options);
}

}  // namespace

bool IsImageEnding(const std::string& ending) {
  return ending == ".png" || ending == ".pgm" || IsTiff(ending);
}

std::vector<RawRow> RowsOfImage(const std::string& bytes, const std::string& ending,
                                const ProfileFileOptions& options) {
  if (IsTiff(ending)) return RowsOfTiff(bytes, options);
  const auto image =
      ending == ".png" ? image::DecodePng<image::Grey16>(bytes) : image::DecodePgm(bytes);
  return RowsOf(image, options.grey, options);
}

}  // namespace rangegrasp::seam
