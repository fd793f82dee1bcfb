#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "mesh/mesh_object.h"

namespace rangegrasp::objects {

/// What an object's file says beside its shape.
struct ObjectLook {
  std::string name;     ///< letters, digits and '_'
  std::string title;    ///< as it shall stand in tables
  std::string surface;  ///< a word of surfaces.yaml
  double albedo = 0.6;
  double gloss = 0.1;
  double clarity = 0.0;
  double specular = 0.2;   ///< of pictures
  double shininess = 0.3;  ///< of pictures
  double table_mu = 0.25;
  std::string texture_png;  ///< a PNG's bytes; may be empty
};

/// A file's name as that of an object: letters, digits and '_'.
std::string ObjectNameFrom(const std::string& text);

/// The files of an object's folder by their names, MJCF and meshes as in models/objects.
std::map<std::string, std::string> ObjectFiles(const MeshObject& object, const ObjectLook& look);

}  // namespace rangegrasp::objects
