#include "draw/canvas.h"

#include <GL/gl.h>
#include <GL/osmesa.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "core/error.h"

namespace rangegrasp::draw {
namespace {

// Drawn twice as large in both directions and averaged: smooth edges without multisampling.
constexpr int kOversampling = 2;

struct ContextDeleter {
  void operator()(osmesa_context* context) const { OSMesaDestroyContext(context); }
};

void LoadMatrix(GLenum mode, const Eigen::Matrix4d& matrix) {
  glMatrixMode(mode);
  glLoadMatrixd(matrix.data());
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
  glViewport(0, 0, width, height);
  glClearColor(1.0F, 1.0F, 1.0F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  const double distance = (view.eye - view.target).norm();
  LoadMatrix(GL_PROJECTION, Perspective(view.field_of_view_rad, static_cast<double>(width) / height,
                                        0.02 * distance, 20.0 * distance));
  LoadMatrix(GL_MODELVIEW, LookAt(view));
}

void DrawDots(const Canvas::Dots& dots) {
  glPointSize(dots.size_px * kOversampling);
  glColor4fv(dots.color.data());
  glBegin(GL_POINTS);
  for (const Eigen::Vector3d& p : dots.points) glVertex3dv(p.data());
  glEnd();
}

void DrawLine(const Canvas::Line& line) {
  glLineWidth(line.width_px * kOversampling);
  glColor4fv(line.color.data());
  glBegin(GL_LINE_STRIP);
  for (const Eigen::Vector3d& p : line.points) glVertex3dv(p.data());
  glEnd();
}

// Flat shading by a light at the eye, brighter from above; computed here, so that it does not
// depend on winding.
void DrawSurface(const Canvas::Surface& surface, const View& view) {
  glDepthMask(surface.color[3] < 1.0F ? GL_FALSE : GL_TRUE);
  glBegin(GL_TRIANGLES);
  for (const auto& triangle : surface.mesh.triangles) {
    const auto& v = surface.mesh.vertices;
    const Eigen::Vector3d normal =
        (v[triangle[1]] - v[triangle[0]]).cross(v[triangle[2]] - v[triangle[0]]).normalized();
    const Eigen::Vector3d light = (view.eye - v[triangle[0]]).normalized() + 0.5 * view.up;
    const auto shade =
        static_cast<float>(0.35 + 0.6 * std::min(1.0, std::abs(normal.dot(light.normalized()))));
    glColor4f(surface.color[0] * shade, surface.color[1] * shade, surface.color[2] * shade,
              surface.color[3]);
    for (const auto i : triangle) glVertex3dv(v[i].data());
  }
  glEnd();
  glDepthMask(GL_TRUE);
}

sim::Image Downsample(const std::vector<std::uint8_t>& rgba, int width, int height) {
  sim::Image image;
  image.width = width;
  image.height = height;
  image.rgb.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  const int big_width = width * kOversampling;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int s = 0; s < kOversampling * kOversampling; ++s) {
          // OSMesa's rows go upwards, an image's downwards.
          const int from_y = (height - 1 - y) * kOversampling + s / kOversampling;
          const int from_x = x * kOversampling + s % kOversampling;
          sum += rgba[static_cast<std::size_t>((from_y * big_width + from_x) * 4 + c)];
        }
        image.rgb[static_cast<std::size_t>((y * width + x) * 3 + c)] =
            static_cast<std::uint8_t>(sum / (kOversampling * kOversampling));
      }
    }
  }
  return image;
}

}  // namespace

Color PaletteColor(std::size_t i) {
  // Hues by the golden angle: every new one falls into the largest gap.
  const double hue = std::fmod(0.05 + 0.61803398875 * static_cast<double>(i), 1.0) * 6.0;
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + hue, 6.0);
    return static_cast<float>(0.85 - 0.7 * std::max(0.0, std::min({k, 4.0 - k, 1.0})));
  };
  return {channel(5.0), channel(3.0), channel(1.0), 1.0F};
}

sim::Image Render(const Canvas& canvas, const View& view, int width, int height) {
  if (width < 1 || height < 1) throw std::invalid_argument("a picture needs a positive size");
  const std::unique_ptr<osmesa_context, ContextDeleter> context(
      OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, nullptr));
  const int big_width = width * kOversampling;
  const int big_height = height * kOversampling;
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(big_width) *
                                 static_cast<std::size_t>(big_height) * 4);
  if (!context ||
      !OSMesaMakeCurrent(context.get(), rgba.data(), GL_UNSIGNED_BYTE, big_width, big_height)) {
    throw core::RunError("no offscreen OpenGL context of " + std::to_string(big_width) + " x " +
                         std::to_string(big_height) + " pixels can be made (OSMesa)");
  }
  SetUp(view, big_width, big_height);
  for (const auto& dots : canvas.dots) DrawDots(dots);
  for (const auto& line : canvas.lines) DrawLine(line);
  for (const auto& surface : canvas.surfaces) DrawSurface(surface, view);
  glFinish();
  OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
  return Downsample(rgba, width, height);
}

}  // namespace rangegrasp::draw
