// An example of a grasp detector in C++ with nlohmann-json (docs/bring-your-own-detector.md).
//
// It returns no objects: it finds the highest thing on the table and proposes grasps from above
// across its narrow side. Build it with: g++ -std=c++20 -O2 from_above.cpp -o from_above
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using nlohmann::json;
using Vec = std::array<double, 3>;

constexpr double kClearance_m = 0.008;  // lower points belong to the table
constexpr double kCell_m = 0.006;       // wider gaps, seen from above, separate things
constexpr double kFingers_m = 0.018;    // half of the hand's breadth
constexpr double kMinHeight_m = 0.010;  // of the pads; collisions of the hand are checked later
constexpr double kRoom_m = 0.004;       // between the open pads and the widest thing

Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(double s, const Vec& a) { return {s * a[0], s * a[1], s * a[2]}; }
double Dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec Cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec Unit(const Vec& a) { return 1.0 / std::sqrt(Dot(a, a)) * a; }

// The measured points of the given PCD file: binary, x y z first, 4 bytes each.
std::vector<Vec> ReadCloud(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  std::size_t count = 0;
  std::size_t fields = 0;
  std::string line;
  while (std::getline(file, line) && line.rfind("DATA", 0) != 0) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "POINTS") words >> count;
    if (word == "FIELDS") {
      for (fields = 0; words >> word;) ++fields;
    }
  }
  if (!file || line != "DATA binary") throw std::runtime_error(name + ": no binary PCD");
  std::vector<Vec> points;
  std::vector<float> row(fields);
  const auto bytes = static_cast<std::streamsize>(fields * sizeof(float));
  for (std::size_t i = 0; i < count && file.read(reinterpret_cast<char*>(row.data()), bytes); ++i) {
    if (std::isfinite(row[0])) points.push_back({row[0], row[1], row[2]});
  }
  return points;
}

// The points of the highest thing: those connected to the highest point through neighboring cells
// of a grid on the table. Coordinates: two on the table, and height.
std::vector<Vec> HighestThing(const std::vector<Vec>& on_table) {
  std::map<std::pair<int, int>, std::vector<Vec>> cells;
  const Vec* top = nullptr;
  const auto cell_of = [](const Vec& p) {
    return std::pair(static_cast<int>(std::floor(p[0] / kCell_m)),
                     static_cast<int>(std::floor(p[1] / kCell_m)));
  };
  for (const Vec& p : on_table) {
    cells[cell_of(p)].push_back(p);
    if (!top || p[2] > (*top)[2]) top = &p;
  }
  std::vector<Vec> thing;
  if (!top) return thing;
  std::vector<std::pair<int, int>> front{cell_of(*top)};
  while (!front.empty()) {
    const auto at = front.back();
    front.pop_back();
    const auto cell = cells.find(at);
    if (cell == cells.end()) continue;
    thing.insert(thing.end(), cell->second.begin(), cell->second.end());
    cells.erase(cell);
    for (int k = 0; k < 9; ++k) front.emplace_back(at.first + k % 3 - 1, at.second + k / 3 - 1);
  }
  return thing;
}

}  // namespace

int main() {
  std::string line;
  std::getline(std::cin, line);
  const json question = json::parse(line);
  const json& workspace = question["workspace"];
  const Vec center = workspace["center_m"];
  const Vec up = workspace["up"];
  const double reach_m = workspace["radius_m"].get<double>() + workspace["margin_m"].get<double>();
  const double opening_m = question["hand"]["opening_m"];
  const Vec east = Unit(Cross({0.0, 1.0, 0.0}, up));
  const Vec north = Cross(up, east);

  std::vector<Vec> on_table;
  for (const Vec& p : ReadCloud(question["observation"])) {
    const Vec off = p - center;
    const Vec own = {Dot(off, east), Dot(off, north), Dot(off, up)};
    if (own[2] > kClearance_m && std::hypot(own[0], own[1]) < reach_m) on_table.push_back(own);
  }
  const std::vector<Vec> thing = HighestThing(on_table);

  json grasps = json::array();
  constexpr int kDirections = 72;
  for (int k = 0; k < kDirections && thing.size() > 40; ++k) {
    const double angle = 2.0 * M_PI * k / kDirections;
    const Vec x = {std::cos(angle), std::sin(angle), 0.0};
    const Vec y = {x[1], -x[0], 0.0};  // z x x, where z points down
    double low = 1.0, high = -1.0, left = 1.0, right = -1.0, top = 0.0;
    for (const Vec& p : thing) {
      left = std::min(left, Dot(p, y));
      right = std::max(right, Dot(p, y));
    }
    const double middle = 0.5 * (left + right);
    for (const Vec& p : thing) {
      if (std::abs(Dot(p, y) - middle) > kFingers_m) continue;
      low = std::min(low, Dot(p, x));
      high = std::max(high, Dot(p, x));
      top = std::max(top, p[2]);
    }
    const double width_m = high - low;
    if (width_m <= 0.0 || width_m > opening_m - kRoom_m) continue;
    for (const double depth_m : {0.030, 0.020, 0.012}) {
      const double height_m = std::max(top - depth_m, std::min(kMinHeight_m, 0.5 * top));
      const Vec at = 0.5 * (low + high) * x + middle * y;
      const Vec position = center + at[0] * east + at[1] * north + height_m * up;
      const Vec x_W = x[0] * east + x[1] * north;
      const Vec y_W = y[0] * east + y[1] * north;
      const Vec z_W = -1.0 * up;
      grasps.push_back(
          {{"position_m", position},
           {"rotation",
            {{x_W[0], y_W[0], z_W[0]}, {x_W[1], y_W[1], z_W[1]}, {x_W[2], y_W[2], z_W[2]}}},
           {"width_m", width_m},
           {"score", -width_m + 0.2 * depth_m}});
    }
  }
  std::cout << json{{"grasps", grasps}} << std::endl;
}
