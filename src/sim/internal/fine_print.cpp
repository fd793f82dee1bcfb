#include "sim/internal/fine_print.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <string_view>
#include <tuple>

#include "base/rng.h"
#include "base/units.h"
#include "sim/internal/engine.h"

namespace rangegrasp::sim::internal {
namespace {

using image::Image;

constexpr double kFineTexel_mm = 0.17;  // half a pixel of a camera with 3 pixels per mm
constexpr int kMaxTexels = 2048;        // per edge
constexpr double kLinePitch_mm = 2.4;   // line spacing of ingredient lists
constexpr double kLetter_mm = 1.5;      // height of their letters
constexpr double kLetterPitch_mm = 1.05;
constexpr double kBar_mm = 0.5;    // module of a bar code, which has 95
constexpr double kGrain_mm = 0.5;  // patches of unevenness
constexpr int kEmptyLevels = 12;   // a region with less contrast than this is empty
constexpr int kTries = 400;        // to place blocks
constexpr int kChannels = 3;

struct Rectangle {
  int x, y, width, height;

  bool Overlaps(const Rectangle& other) const {
    return x < other.x + other.width && other.x < x + width && y < other.y + other.height &&
           other.y < y + height;
  }
};

// 32 random bits for a position, independent of the order of draws.
std::uint32_t Hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x8da6b343u + y * 0xd8163841u + seed * 0xcb1ab31fu;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 12;
  h *= 0x297a2d39u;
  return h ^ (h >> 15);
}

class Printer {
 public:
  Printer(const Image& label, double mm_per_texel, std::uint64_t seed)
      : rng_(seed), seed_(static_cast<std::uint32_t>(seed)) {
    const int longest = std::max(label.width, label.height);
    factor_ = std::clamp(static_cast<int>(std::lround(mm_per_texel / kFineTexel_mm)), 1,
                         std::max(1, kMaxTexels / longest));
    texels_per_mm_ = factor_ / mm_per_texel;
    Enlarge(label);
  }

  void Fill(double coverage) {
    const double wanted = coverage * page_.width * page_.height;
    double filled = 0.0;
    for (int i = 0; i < kTries && filled < wanted; ++i) {
      const Rectangle block = DrawBlock(blocks_.empty());
      if (!IsFree(block)) continue;
      blocks_.empty() ? BarCode(block) : List(block);
      blocks_.push_back(block);
      filled += double(block.width) * block.height;
    }
  }

  void Pictures(int count) {
    for (int i = 0; i < count; ++i) {
      const int radius = Texels(rng_.Uniform(10.0, 22.0));
      const auto x = static_cast<int>(rng_.Uniform(0.0, page_.width));
      const auto y = static_cast<int>(rng_.Uniform(0.0, page_.height));
      Picture(x, y, radius);
    }
  }

  void Grain(double levels) {
    const int cell = std::max(1, Texels(kGrain_mm));
    for (int y = 0; y < page_.height; ++y) {
      for (int x = 0; x < page_.width; x += cell) {
        // The sum of four random bytes approximates a normal distribution.
        const std::uint32_t h = Hash(x / cell, y / cell, seed_);
        const int sum = (h & 255u) + (h >> 8 & 255u) + (h >> 16 & 255u) + (h >> 24);
        const int shift = static_cast<int>(std::lround(levels * (sum - 510) / 148.0));
        for (int u = x; u < std::min(x + cell, page_.width); ++u) Shift(At(u, y), shift);
      }
    }
  }

  Image Take() { return std::move(page_); }

 private:
  int Texels(double mm) const { return static_cast<int>(std::lround(mm * texels_per_mm_)); }
  std::uint8_t* At(int x, int y) {
    return page_.rgb.data() + kChannels * image::IndexAt(x, y, page_.width);
  }
  static void Shift(std::uint8_t* texel, int levels) {
    for (int c = 0; c < kChannels; ++c) {
      texel[c] = static_cast<std::uint8_t>(std::clamp(texel[c] + levels, 0, 255));
    }
  }
  static int Brightness(const std::uint8_t* texel) {
    return (2 * texel[0] + 5 * texel[1] + texel[2]) / 8;
  }

  void Enlarge(const Image& label) {
    page_.width = label.width * factor_;
    page_.height = label.height * factor_;
    page_.rgb.resize(kChannels * image::IndexAt(0, page_.height, page_.width));
    // The center of texel i lies at factor * (i + 1/2). Two texels mix with weights that add up to
    // 2 * factor, first along columns, then along rows.
    const int whole = 2 * factor_;
    const auto edge = [](int i, int size) { return std::clamp(i, 0, size - 1); };
    std::vector<int> column(std::size_t(label.width) * kChannels);
    for (int y = 0; y < page_.height; ++y) {
      const int at_y = 2 * y + 1 + factor_;  // shifted by one texel, so that it is not negative
      const int row = at_y / whole - 1;
      const int down = at_y % whole;
      const std::ptrdiff_t stride = std::ptrdiff_t{kChannels} * label.width;
      const std::uint8_t* upper = label.rgb.data() + stride * edge(row, label.height);
      const std::uint8_t* lower = label.rgb.data() + stride * edge(row + 1, label.height);
      for (std::size_t i = 0; i < column.size(); ++i) {
        column[i] = upper[i] * (whole - down) + lower[i] * down;
      }
      const int scale = (1 << 16) / (whole * whole) + 1;
      std::uint8_t* out = At(0, y);
      for (int x = 0; x < page_.width; ++x) {
        const int at_x = 2 * x + 1 + factor_;
        const int right = at_x % whole;
        const int* a = column.data() + kChannels * edge(at_x / whole - 1, label.width);
        const int* b = column.data() + kChannels * edge(at_x / whole, label.width);
        for (int k = 0; k < kChannels; ++k) {
          *out++ =
              static_cast<std::uint8_t>(((a[k] * (whole - right) + b[k] * right) * scale) >> 16);
        }
      }
    }
  }

  Rectangle DrawBlock(bool code) {
    Rectangle block;
    block.width = Texels(code ? 95 * kBar_mm * 0.66 : rng_.Uniform(9.0, 34.0));
    block.height = Texels(code ? 14.0 : rng_.Uniform(7.0, 30.0));
    block.x = static_cast<int>(rng_.Uniform(0.0, page_.width - block.width));
    block.y = static_cast<int>(rng_.Uniform(0.0, page_.height - block.height));
    return block;
  }

  bool IsFree(const Rectangle& block) {
    if (block.width >= page_.width || block.height >= page_.height) return false;
    const auto overlaps = [&](const Rectangle& other) { return block.Overlaps(other); };
    if (std::ranges::any_of(blocks_, overlaps)) return false;
    int low = 255, high = 0;
    for (int y = block.y; y < block.y + block.height; y += factor_) {
      for (int x = block.x; x < block.x + block.width; x += factor_) {
        const int level = Brightness(At(x, y));
        low = std::min(low, level);
        high = std::max(high, level);
      }
    }
    return high - low < kEmptyLevels;
  }

  // Lines of words of letters; a letter is a pattern of strokes on a grid of 3 by 5.
  void List(const Rectangle& block) {
    const int ink = Brightness(At(block.x, block.y)) > 110 ? -120 : 130;
    const int pitch = std::max(3, Texels(kLinePitch_mm));
    const int height = std::max(2, Texels(kLetter_mm));
    const int advance = std::max(2, Texels(kLetterPitch_mm));
    const int width = std::max(1, advance * 3 / 4);
    for (int y = block.y; y + height < block.y + block.height; y += pitch) {
      int letters = 0;
      for (int x = block.x; x + advance < block.x + block.width; x += advance) {
        if (letters-- == 0) {
          letters = 2 + static_cast<int>(rng_.Index(9));
          continue;
        }
        const std::uint64_t strokes = rng_.Next() | rng_.Next();  // three quarters are inked
        for (int v = 0; v < height; ++v) {
          for (int u = 0; u < width; ++u) {
            const int cell = 3 * (5 * v / height) + 3 * u / width;
            if (strokes >> cell & 1) Shift(At(x + u, y + v), ink);
          }
        }
      }
    }
  }

  void BarCode(const Rectangle& block) {
    const int bar = std::max(1, Texels(0.66 * kBar_mm));
    for (int x = 0; x < block.width; ++x) {
      const bool dark = Hash(x / bar, 7, seed_) & 1u;
      const bool quiet = x < 3 * bar || x >= block.width - 3 * bar;
      for (int y = 0; y < block.height; ++y) {
        std::uint8_t* texel = At(block.x + x, block.y + y);
        const bool ink = dark && !quiet && y > 2 * bar && y < block.height - 2 * bar;
        std::fill_n(texel, kChannels, static_cast<std::uint8_t>(ink ? 30 : 240));
      }
    }
  }

  // Smooth noise with three sizes of blotches that fades towards the picture's edge.
  void Picture(int center_x, int center_y, int radius) {
    const auto salt = static_cast<std::uint32_t>(rng_.Next());
    const int top = std::max(0, center_y - radius), left = std::max(0, center_x - radius);
    const int bottom = std::min(page_.height, center_y + radius);
    const int right = std::min(page_.width, center_x + radius);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const double away = std::hypot(x - center_x, y - center_y) / radius;
        if (away >= 1.0) continue;
        double level = 0.0;
        for (int octave = 0; octave < 3; ++octave) {
          level += Smooth(x, y, std::max(2, Texels(6.0) >> octave), salt + octave) * (50 >> octave);
        }
        Shift(At(x, y), static_cast<int>(level * std::min(1.0, 4.0 * (1.0 - away))));
      }
    }
  }

  // Noise from -1 to 1, bilinear between the corners of cells.
  static double Smooth(int x, int y, int cell, std::uint32_t salt) {
    const auto corner = [&](int i, int j) {
      return Hash(x / cell + i, y / cell + j, salt) * 0x1.0p-31 - 1.0;
    };
    const double u = double(x % cell) / cell, v = double(y % cell) / cell;
    return (corner(0, 0) * (1 - u) + corner(1, 0) * u) * (1 - v) +
           (corner(0, 1) * (1 - u) + corner(1, 1) * u) * v;
  }

  base::Rng rng_;
  std::uint32_t seed_;
  int factor_ = 1;
  double texels_per_mm_ = 1.0;
  Image page_;
  std::vector<Rectangle> blocks_;
};

// The texture of an object's label and the size of its texels on the object; -1 for none.
int LabelOf(const mjModel* model, int root, double& mm_per_texel) {
  for (int geom = 0; geom < model->ngeom; ++geom) {
    const int texture = TextureOf(model, geom);
    if (model->body_rootid[model->geom_bodyid[geom]] != root || texture < 0) continue;
    if (model->tex_nchannel[texture] != kChannels) continue;
    const int mesh = model->geom_dataid[geom];
    const geometry::TriangleMesh surface = mjcf::MeshOf(model, mesh);
    const float* places = model->mesh_texcoord + 2 * model->mesh_texcoordadr[mesh];
    const int* at = model->mesh_facetexcoord + 3 * model->mesh_faceadr[mesh];
    double area_m2 = 0.0, share = 0.0;
    for (const auto& corners : surface.triangles) {
      std::array<Eigen::Vector3d, 3> p;
      std::array<Eigen::Vector2d, 3> uv;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = surface.vertices[corners[i]];
        uv[i] = Eigen::Map<const Eigen::Vector2f>(places + 2 * *at++).cast<double>();
      }
      const Eigen::Vector2d a = uv[1] - uv[0], b = uv[2] - uv[0];
      const double printed = 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
      if (printed == 0.0) continue;  // of one colour
      share += printed;
      area_m2 += 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
    }
    const double texels = share * model->tex_width[texture] * model->tex_height[texture];
    if (texels <= 0.0) continue;
    mm_per_texel = std::sqrt(area_m2 / texels) * base::kMmPerM;
    return texture;
  }
  return -1;
}

Image TextureIn(const mjModel* model, int texture) {
  const int width = model->tex_width[texture], height = model->tex_height[texture];
  const mjtByte* first = model->tex_data + model->tex_adr[texture];
  return {width, height, {first, first + kChannels * width * height}};
}

// Printed once in this process or the one it was forked from: it takes a tenth of a picture's time.
const Image& Printed(const Image& label, double mm_per_texel, const FinePrint& print) {
  // The print depends only on the label: it is the same in all scenes.
  const std::uint64_t seed = base::DeriveSeed(
      0, std::string_view(reinterpret_cast<const char*>(label.rgb.data()), label.rgb.size()));
  using Key = std::tuple<std::uint64_t, double, double, int, double>;
  static std::map<Key, Image> printed;
  static std::mutex one_at_a_time;
  const std::scoped_lock lock(one_at_a_time);
  const Key key(seed, mm_per_texel, print.coverage, print.pictures, print.grain_levels);
  auto found = printed.find(key);
  if (found == printed.end()) {
    found = printed.emplace(key, WithFinePrint(label, mm_per_texel, print, seed)).first;
  }
  return found->second;
}

// Cardboard is printed all over, metal and tubs less. Bottles have a small label at the back,
// ceramics have no print.
FinePrint FinePrintOf(std::string_view surface) {
  if (surface == "cardboard") return {0.30, 2, 2.5};
  if (surface == "painted_metal") return {0.15, 1, 1.0};
  if (surface == "plastic") return {0.12, 0, 1.0};
  if (surface == "hdpe" || surface == "pet") return {0.04, 0, 0.5};
  return {};
}

}  // namespace

Image WithFinePrint(const Image& label, double mm_per_texel, const FinePrint& print,
                    std::uint64_t seed) {
  Printer printer(label, mm_per_texel, seed);
  printer.Pictures(print.pictures);
  printer.Fill(print.coverage);
  if (print.grain_levels > 0.0) printer.Grain(print.grain_levels);
  return printer.Take();
}

TextureSet::TextureSet(const World& world) {
  const mjModel* model = world.model();
  width_.assign(model->tex_width, model->tex_width + model->ntex);
  height_.assign(model->tex_height, model->tex_height + model->ntex);
  std::vector<const Image*> replaced(model->ntex, nullptr);
  for (int object = 0; object < world.objects(); ++object) {
    double mm_per_texel = 0.0;
    const int texture = LabelOf(model, world.object_body(object), mm_per_texel);
    const FinePrint print = FinePrintOf(world.object_surface(object));
    if (texture < 0 || (print.coverage == 0.0 && print.grain_levels == 0.0)) continue;
    const Image& printed = Printed(TextureIn(model, texture), mm_per_texel, print);
    width_[texture] = printed.width;
    height_[texture] = printed.height;
    replaced[texture] = &printed;
  }
  for (std::size_t t = 0; t < replaced.size(); ++t) {
    address_.push_back(static_cast<mjtSize>(data_.size()));
    if (replaced[t]) {
      data_.insert(data_.end(), replaced[t]->rgb.begin(), replaced[t]->rgb.end());
      continue;
    }
    const mjtByte* first = model->tex_data + model->tex_adr[t];
    data_.insert(data_.end(), first,
                 first + std::ptrdiff_t{width_[t]} * height_[t] * model->tex_nchannel[t]);
  }
}

void TextureSet::PutInto(mjModel& model) {
  model.ntexdata = static_cast<mjtSize>(data_.size());
  model.tex_width = width_.data();
  model.tex_height = height_.data();
  model.tex_adr = address_.data();
  model.tex_data = data_.data();
}

}  // namespace rangegrasp::sim::internal
