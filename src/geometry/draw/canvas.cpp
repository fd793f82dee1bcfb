#include "geometry/draw/canvas.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/image/offscreen_context.h"
#include "base/image/open_gl.h"

namespace rangegrasp::draw {
namespace {

// Images are drawn at twice the size and averaged: smooth edges without multisampling.
constexpr int kOversampling = 2;
// Near and far clipping planes, in units of the viewing distance.
constexpr double kNear = 0.02;
constexpr double kFar = 20.0;
// Brightness of a surface seen edge-on, and the increase for a surface that faces the light. The
// light is at the eye, raised by a part of the view's up vector.
constexpr double kAmbient = 0.35;
constexpr double kDiffuse = 0.6;
constexpr double kLightRise = 0.5;

void LoadMatrix(GLenum mode, const Eigen::Matrix4d& matrix) {
  const image::OpenGl& gl = image::Gl();
  gl.matrix_mode(mode);
  gl.load_matrixd(matrix.data());
}

Eigen::Matrix4d Perspective(double field_of_view, double aspect, double near, double far) {
  const double f = 1.0 / std::tan(0.5 * field_of_view);
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = f / aspect;
  m(1, 1) = f;
  m(2, 2) = (far + near) / (near - far);
  m(2, 3) = 2.0 * far * near / (near - far);
  m(3, 2) = -1.0;
  return m;
}

Eigen::Matrix4d LookAt(const View& view) {
  const Eigen::Vector3d z = (view.eye - view.target).normalized();
  const Eigen::Vector3d x = view.up.cross(z).normalized();
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<1, 3>(0, 0) = x.transpose();
  m.block<1, 3>(1, 0) = z.cross(x).transpose();
  m.block<1, 3>(2, 0) = z.transpose();
  m.block<3, 1>(0, 3) = -m.block<3, 3>(0, 0) * view.eye;
  return m;
}

void SetUp(const View& view, int width, int height) {
  const image::OpenGl& gl = image::Gl();
  gl.viewport(0, 0, width * kOversampling, height * kOversampling);
  gl.clear_color(1.0F, 1.0F, 1.0F, 1.0F);
  gl.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl.enable(GL_DEPTH_TEST);
  gl.enable(GL_BLEND);
  gl.blend_func(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  const double distance = (view.eye - view.target).norm();
  LoadMatrix(GL_PROJECTION, Perspective(view.field_of_view_rad, static_cast<double>(width) / height,
                                        kNear * distance, kFar * distance));
  LoadMatrix(GL_MODELVIEW, LookAt(view));
}

void DrawPoints(GLenum as, const geometry::Points& points, const Color& color) {
  const image::OpenGl& gl = image::Gl();
  gl.color4fv(color.data());
  gl.begin(as);
  for (const Eigen::Vector3d& p : points) gl.vertex3dv(p.data());
  gl.end();
}

// Flat shading for any winding, by a light at the eye, brighter from above.
void DrawSurface(const Canvas::Surface& surface, const View& view) {
  const image::OpenGl& gl = image::Gl();
  gl.depth_mask(surface.color[3] < 1.0F ? GL_FALSE : GL_TRUE);
  gl.begin(GL_TRIANGLES);
  for (const auto& triangle : surface.mesh.triangles) {
    const auto& v = surface.mesh.vertices;
    const Eigen::Vector3d normal =
        (v[triangle[1]] - v[triangle[0]]).cross(v[triangle[2]] - v[triangle[0]]).normalized();
    const Eigen::Vector3d light = (view.eye - v[triangle[0]]).normalized() + kLightRise * view.up;
    const auto shade = static_cast<float>(
        kAmbient + kDiffuse * std::min(1.0, std::abs(normal.dot(light.normalized()))));
    gl.color4f(surface.color[0] * shade, surface.color[1] * shade, surface.color[2] * shade,
               surface.color[3]);
    for (const auto i : triangle) gl.vertex3dv(v[i].data());
  }
  gl.end();
  gl.depth_mask(GL_TRUE);
}

}  // namespace

Color PaletteColor(std::size_t i) {
  // Hues by the golden angle: each new one falls into the widest gap. The first is orange.
  constexpr double kFirstHue = 0.05;  // share of the hue circle
  constexpr double kTurn = 1.0 / std::numbers::phi;
  constexpr double kBright = 0.85;  // the strongest channel, and how much lower the weakest is
  constexpr double kSpread = 0.7;
  const double hue = std::fmod(kFirstHue + kTurn * static_cast<double>(i), 1.0) * 6.0;
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + hue, 6.0);
    return static_cast<float>(kBright - kSpread * std::max(0.0, std::min({k, 4.0 - k, 1.0})));
  };
  return {channel(5.0), channel(3.0), channel(1.0), 1.0F};
}

image::Image Render(const Canvas& canvas, const View& view, int width, int height) {
  image::OffscreenContext context(width * kOversampling, height * kOversampling);
  const image::OpenGl& gl = image::Gl();
  SetUp(view, width, height);
  for (const auto& dots : canvas.dots) {
    gl.point_size(dots.size_px * kOversampling);
    DrawPoints(GL_POINTS, dots.points, dots.color);
  }
  for (const auto& line : canvas.lines) {
    gl.line_width(line.width_px * kOversampling);
    DrawPoints(GL_LINE_STRIP, line.points, line.color);
  }
  for (const auto& surface : canvas.surfaces) DrawSurface(surface, view);
  return context.Picture(kOversampling);
}

}  // namespace rangegrasp::draw
