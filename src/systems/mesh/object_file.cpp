#include "mesh/object_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/units.h"

namespace rangegrasp::objects {
namespace {

std::string Escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

// Of what is shorter than the meshes' own rounding.
std::string Number(double value) {
  const std::string text = fmt::format("{:.6g}", value);
  return text == "-0" ? "0" : text;
}

void AppendVertices(const geometry::TriangleMesh& mesh, std::string& text) {
  // A tenth of a micrometre: far below what a mesh is good for.
  for (const Eigen::Vector3d& v : mesh.vertices) {
    text += fmt::format("v {:.7f} {:.7f} {:.7f}\n", v.x(), v.y(), v.z());
  }
}

std::string HullObj(const geometry::TriangleMesh& mesh) {
  std::string text;
  AppendVertices(mesh, text);
  for (const auto& [a, b, c] : mesh.triangles) {
    text += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
  }
  return text;
}

std::string SeenObj(const MeshObject& object) {
  if (object.uv.empty()) return HullObj(object.seen_O);
  std::string text;
  AppendVertices(object.seen_O, text);
  for (const auto& corners : object.uv) {
    for (const Eigen::Vector2d& uv : corners) {
      text += fmt::format("vt {:.5f} {:.5f}\n", uv.x(), uv.y());
    }
  }
  std::size_t corner = 1;
  for (const auto& [a, b, c] : object.seen_O.triangles) {
    text +=
        fmt::format("f {}/{} {}/{} {}/{}\n", a + 1, corner, b + 1, corner + 1, c + 1, corner + 2);
    corner += 3;
  }
  return text;
}

std::string Mjcf(const MeshObject& object, const ObjectLook& look) {
  const Eigen::Matrix3d& inertia = object.inertia_O;
  const double grey = look.albedo;
  const bool printed = !look.texture_png.empty();
  std::string text = fmt::format(
      R"(<mujoco model="{0}">
  <!-- {1:.3g} kg, {2:.0f} x {3:.0f} x {4:.0f} mm. Origin in the middle of the box round it. Made by rangegrasp add-object;
       numbers may be changed by hand. -->
  <custom>
    <text name="title" data="{5}"/>
    <text name="surface" data="{6}"/>
    <numeric name="albedo" data="{7}"/>
    <numeric name="gloss" data="{8}"/>
    <numeric name="clarity" data="{9}"/>
  </custom>
)",
      look.name, object.mass_kg, object.size_m.x() * base::kMmPerM,
      object.size_m.y() * base::kMmPerM, object.size_m.z() * base::kMmPerM, Escaped(look.title),
      Escaped(look.surface), Number(look.albedo), Number(look.gloss), Number(look.clarity));
  text += fmt::format(
      R"(  <default>
    <default class="visual">
      <geom group="2" contype="0" conaffinity="0" type="mesh" material="label"/>
    </default>
    <default class="collision">
      <!-- Friction on the table's laminate (kinetic), spin and rolling resistance [m]. -->
      <geom group="3" condim="6" friction="{} 0.003 0.0005" solref="0.005 1" solimp="0.95 0.99 0.001 0.5 2"/>
    </default>
  </default>
  <asset>
)",
      Number(look.table_mu));
  if (printed) text += "    <texture name=\"label\" type=\"2d\" file=\"label.png\"/>\n";
  text += fmt::format("    <material name=\"label\" {} specular=\"{}\" shininess=\"{}\"/>\n",
                      printed ? std::string("texture=\"label\"")
                              : fmt::format("rgba=\"{0} {0} {0} 1\"", Number(grey)),
                      Number(look.specular), Number(look.shininess));
  text += "    <mesh name=\"visual\" file=\"visual.obj\"/>\n";
  for (std::size_t i = 0; i < object.hulls_O.size(); ++i) {
    text += fmt::format("    <mesh name=\"hull{0}\" file=\"hull{0}.obj\"/>\n", i);
  }
  text += fmt::format(
      R"(  </asset>
  <worldbody>
    <body name="{0}">
      <freejoint name="{0}"/>
      <inertial mass="{1}" pos="{2} {3} {4}" fullinertia="{5} {6} {7} {8} {9} {10}"/>
      <geom name="visual" class="visual" mesh="visual"/>
)",
      look.name, Number(object.mass_kg), Number(object.center_O.x()), Number(object.center_O.y()),
      Number(object.center_O.z()), Number(inertia(0, 0)), Number(inertia(1, 1)),
      Number(inertia(2, 2)), Number(inertia(0, 1)), Number(inertia(0, 2)), Number(inertia(1, 2)));
  for (std::size_t i = 0; i < object.hulls_O.size(); ++i) {
    text += fmt::format(
        "      <geom name=\"hull{0}\" class=\"collision\" type=\"mesh\" mesh=\"hull{0}\"/>\n", i);
  }
  return text + "    </body>\n  </worldbody>\n</mujoco>\n";
}

}  // namespace

std::string ObjectNameFrom(const std::string& text) {
  std::string name = text;
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

std::map<std::string, std::string> ObjectFiles(const MeshObject& object, const ObjectLook& look) {
  std::map<std::string, std::string> files;
  files[look.name + ".xml"] = Mjcf(object, look);
  files["visual.obj"] = SeenObj(object);
  for (std::size_t i = 0; i < object.hulls_O.size(); ++i) {
    files[fmt::format("hull{}.obj", i)] = HullObj(object.hulls_O[i]);
  }
  if (!look.texture_png.empty()) files["label.png"] = look.texture_png;
  return files;
}

}  // namespace rangegrasp::objects
