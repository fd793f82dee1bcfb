#include "report/film/internal/mat.h"

#include <opencv2/imgproc.hpp>

namespace rangegrasp::draw::internal {

void Write(const std::string& text, int x, int y, double scale, image::Image& into,
           const Rgb& color) {
  cv::Mat mat = MatOf(into);
  cv::putText(mat, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, scale, color, 1, cv::LINE_AA);
}

}  // namespace rangegrasp::draw::internal
