#include "parts/task/write_parts.h"

#include "base/image/png.h"
#include "parts/shape/segmentation.h"
#include "parts/shape/shape_file.h"
#include "parts/shape_picture.h"

namespace rangegrasp::parts_task {

void WriteParts(const std::filesystem::path& base, const geometry::PolygonMesh& input,
                std::span<const std::int32_t> triangles, int up) {
  // Of the picture: larger shows smaller parts, and takes more time and disk.
  constexpr int kWidth_px = 960;
  constexpr int kHeight_px = 720;
  const auto named = [&](const char* ending) { return base.string() + ending; };
  const auto polygons = parts::LabelsOfPolygons(input, triangles);
  parts::WriteLabels(named(".seg"), polygons);
  const auto labels = input.polygons > 0 ? parts::LabelsOfTriangles(input, polygons) : polygons;
  parts::WriteColoredShape(named(".ply"), input.mesh, labels);
  image::WritePng(named(".png"),
                  draw::Render(draw::DrawLabels(input.mesh, labels, parts::PartColor),
                               draw::LookAtShape(input.mesh.vertices, up), kWidth_px, kHeight_px));
}

}  // namespace rangegrasp::parts_task
