#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>

#include "core/error.h"
#include "geometry/internal/file_bytes.h"
#include "geometry/io.h"

namespace rangegrasp::geometry {
namespace {

core::Pose ToPose(const aiMatrix4x4& m) {
  core::Pose pose = core::Pose::Identity();
  pose.matrix() << static_cast<double>(m.a1), static_cast<double>(m.a2), static_cast<double>(m.a3),
      static_cast<double>(m.a4), static_cast<double>(m.b1), static_cast<double>(m.b2),
      static_cast<double>(m.b3), static_cast<double>(m.b4), static_cast<double>(m.c1),
      static_cast<double>(m.c2), static_cast<double>(m.c3), static_cast<double>(m.c4), 0.0, 0.0,
      0.0, 1.0;
  return pose;
}

TriangleMesh ToMesh(const aiMesh& source) {
  TriangleMesh mesh;
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D& p = source.mVertices[i];
    mesh.vertices.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y),
                               static_cast<double>(p.z));
  }
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines
    mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  return mesh;
}

void Collect(const aiScene& scene, const aiNode& node, const core::Pose& X_WP, TriangleMesh& mesh) {
  const core::Pose X_WN = X_WP * ToPose(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    Append(Transformed(ToMesh(*scene.mMeshes[node.mMeshes[i]]), X_WN), mesh);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    Collect(scene, *node.mChildren[i], X_WN, mesh);
  }
}

void Check(const std::filesystem::path& file, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw core::InputError(file.string() + ": has no triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      throw core::InputError(file.string() + ": vertex " + std::to_string(i) + " is not finite");
    }
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) {
      if (vertex < mesh.vertices.size()) continue;
      throw core::InputError(file.string() + ": a face names vertex " + std::to_string(vertex) +
                             "; there are " + std::to_string(mesh.vertices.size()));
    }
  }
}

}  // namespace

TriangleMesh ReadMesh(const std::filesystem::path& file) {
  const std::string bytes = internal::ReadBytes(file);
  std::string ending = file.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  Assimp::Importer importer;
  // Only positions count: vertices that differ in nothing else are joined.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TEXCOORDS |
                                                          aiComponent_COLORS |
                                                          aiComponent_TANGENTS_AND_BITANGENTS);
  const aiScene* scene = importer.ReadFileFromMemory(
      bytes.data(), bytes.size(),
      aiProcess_RemoveComponent | aiProcess_Triangulate | aiProcess_JoinIdenticalVertices,
      ending.c_str());
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw core::InputError(file.string() + ": cannot be read as OFF, OBJ, STL or PLY (" +
                           importer.GetErrorString() + ")");
  }
  TriangleMesh mesh;
  Collect(*scene, *scene->mRootNode, core::Pose::Identity(), mesh);
  Check(file, mesh);
  return mesh;
}

}  // namespace rangegrasp::geometry
