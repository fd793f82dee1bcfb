#include "geometry/mesh_file.h"

#include <assimp/BaseImporter.h>
#include <assimp/DefaultIOSystem.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cstring>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "geometry/internal/cloud_format.h"
#include "geometry/internal/polygon_soup.h"

namespace rangegrasp::geometry {
namespace {

base::Pose ToPose(const aiMatrix4x4& m) {
  Eigen::Matrix4f matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, 0, 0, 0, 1;
  return base::Pose(matrix.cast<double>());
}

// The readers' flags do not always describe a mesh's faces correctly, and triangulation, which
// trusts them, aborts the program. The importer owns the scene; it is const only to others.
// @return whether there are polygons to triangulate.
bool CorrectFlags(const aiScene& scene) {
  bool polygons = false;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    aiMesh& mesh = *scene.mMeshes[m];
    mesh.mPrimitiveTypes = 0;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const unsigned corners = mesh.mFaces[i].mNumIndices;
      if (corners > 0) mesh.mPrimitiveTypes |= AI_PRIMITIVE_TYPE_FOR_N_INDICES(corners);
    }
    polygons = polygons || (mesh.mPrimitiveTypes & aiPrimitiveType_POLYGON) != 0;
  }
  return polygons;
}

TexturedMesh ToMesh(const aiMesh& source) {
  TexturedMesh result;
  auto& [mesh, uv] = result;
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D& p = source.mVertices[i];
    mesh.vertices.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y),
                               static_cast<double>(p.z));
  }
  const aiVector3D* coordinates = source.mTextureCoords[0];
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines
    mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
    auto& corners = uv.emplace_back();
    for (unsigned k = 0; k < 3; ++k) {
      const aiVector3D at = coordinates ? coordinates[face.mIndices[k]] : aiVector3D();
      corners.at(k) = {static_cast<double>(at.x), static_cast<double>(at.y)};
    }
  }
  return result;
}

void Collect(const aiScene& scene, const aiNode& node, const base::Pose& X_WP,
             TexturedMesh& result) {
  const base::Pose X_WN = X_WP * ToPose(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const TexturedMesh part = ToMesh(*scene.mMeshes[node.mMeshes[i]]);
    Append(Transformed(part.mesh, X_WN), result.mesh);
    result.uv.insert(result.uv.end(), part.uv.begin(), part.uv.end());
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    Collect(scene, *node.mChildren[i], X_WN, result);
  }
}

// Checks faces and vertices, since post-processing trusts them.
void Check(const std::filesystem::path& file, const aiMesh& mesh) {
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& p = mesh.mVertices[i];
    internal::CheckPlace(file, fmt::format("vertex {}", i),
                         Eigen::Vector3f(p.x, p.y, p.z).cast<double>(), internal::kMaxVertex);
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] < mesh.mNumVertices) continue;
      throw base::InputError(fmt::format("{}: a face uses vertex {}; there are {}", file.string(),
                                         face.mIndices[k], mesh.mNumVertices));
    }
  }
}

// assimp takes a text file that is cut off for a whole one with fewer facets.
void CheckTextStl(const std::filesystem::path& file, const std::string& bytes) {
  const std::size_t end = bytes.rfind("endsolid");
  if (end != std::string::npos && bytes.find("facet", bytes.find('\n', end)) == std::string::npos) {
    return;
  }
  throw base::InputError(file.string() + ": is cut off: no `endsolid` after the last facet");
}

// Cuts off the data after the declared facets of a binary file, since assimp would otherwise take
// it for text. Of a file that is too short, assimp does not always find an end.
void CheckStl(const std::filesystem::path& file, std::string& bytes) {
  constexpr std::size_t kHeader_bytes = 80, kFacet_bytes = 50;  // of the binary format
  const auto holds = [&](const char* word) { return bytes.find(word) != std::string::npos; };
  if (holds("facet") && holds("vertex")) return CheckTextStl(file, bytes);
  std::uint32_t facets = 0;
  constexpr std::size_t kBegin_bytes = kHeader_bytes + sizeof(facets);
  if (bytes.size() >= kBegin_bytes) {
    std::memcpy(&facets, bytes.data() + kHeader_bytes, sizeof(facets));
  }
  const std::size_t needed = kBegin_bytes + kFacet_bytes * std::size_t{facets};
  if (facets == 0 || needed > bytes.size()) {
    throw base::InputError(
        fmt::format("{}: is neither text nor binary STL: {} facets are declared, {} bytes follow",
                    file.string(), facets, bytes.size() - std::min(bytes.size(), kBegin_bytes)));
  }
  bytes.resize(needed);
}

// assimp allocates memory for the declared chunks of a binary glTF before it looks for them.
void CheckGlb(const std::filesystem::path& file, const std::string& bytes) {
  constexpr std::size_t kHeader_bytes = 12, kChunkHeader_bytes = 8;  // of the format
  std::size_t at = kHeader_bytes;
  while (at < bytes.size()) {
    std::uint32_t length = 0;
    const std::size_t left = bytes.size() - at;
    if (left >= kChunkHeader_bytes) std::memcpy(&length, bytes.data() + at, sizeof(length));
    if (left < kChunkHeader_bytes || length > left - kChunkHeader_bytes) {
      throw base::InputError(fmt::format("{}: a chunk of {} bytes is declared, {} follow",
                                         file.string(), length, left));
    }
    at += kChunkHeader_bytes + length;
  }
}

// Reads formats with polygons and doubles, which assimp would triangulate and round to floats.
std::optional<internal::PolygonSoup> ReadPolygons(const std::filesystem::path& file,
                                                  const std::string& bytes) {
  if (internal::IsPly(file, bytes)) return internal::ReadPlyPolygons(file, bytes);
  const std::string ending = base::EndingOf(file);
  if (ending == ".off") return internal::ReadOff(file, bytes);
  if (ending == ".obj") return internal::ReadObj(file, bytes);
  return std::nullopt;
}

// Opens only files that are in the mesh's folder after links are resolved: the mesh may be
// untrusted, and name a private file or a device that never ends.
class FolderOnly : public Assimp::DefaultIOSystem {
 public:
  explicit FolderOnly(const std::filesystem::path& file)
      : file_(file),
        folder_(std::filesystem::weakly_canonical(std::filesystem::absolute(file).parent_path())) {}

  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (name != file_ && !IsInside(name)) {
      refused_ = name;
      return nullptr;
    }
    return DefaultIOSystem::Open(name, mode);
  }
  /// Empty if nothing was refused.
  const std::string& refused() const { return refused_; }

 private:
  bool IsInside(const std::filesystem::path& name) const {
    std::error_code error;
    const auto real =
        std::filesystem::weakly_canonical(std::filesystem::absolute(name, error), error);
    if (error || *real.lexically_relative(folder_).begin() == "..") return false;
    return std::filesystem::is_regular_file(real, error) || !std::filesystem::exists(real, error);
  }

  std::filesystem::path file_, folder_;
  std::string refused_;
};

// assimp chooses a reader by a file's content, and some of its readers do not check what they read.
// Only the readers of the formats here are kept.
void KeepOwnFormats(Assimp::Importer& importer) {
  constexpr std::array<std::string_view, 6> kFormats = {"off", "obj", "stl", "ply", "gltf", "glb"};
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    const auto endings = base::Split(importer.GetImporterInfo(i)->mFileExtensions, ' ');
    const bool own = std::ranges::any_of(endings, [&](const std::string& ending) {
      return std::ranges::find(kFormats, ending) != kFormats.end();
    });
    if (own) continue;
    const std::unique_ptr<Assimp::BaseImporter> other(importer.GetImporter(i));
    importer.UnregisterLoader(other.get());
  }
}

TexturedMesh Read(const std::filesystem::path& file, std::string bytes, bool textured) {
  if (base::EndingOf(file) == ".stl") CheckStl(file, bytes);
  if (bytes.starts_with("glTF")) CheckGlb(file, bytes);
  // 3MF is common: the message names a fix. assimp 5.2 ends the program if a 3MF file is damaged.
  if (base::EndingOf(file) == ".3mf") {
    throw base::InputError(file.string() + ": 3MF is not supported; save it as STL, OBJ or glTF");
  }
  std::string ending = file.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  Assimp::Importer importer;
  KeepOwnFormats(importer);
  // Only positions count: vertices that differ only in other attributes are joined.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TEXCOORDS |
                                                          aiComponent_COLORS |
                                                          aiComponent_TANGENTS_AND_BITANGENTS);
  auto* const folder = new FolderOnly(file);
  importer.SetIOHandler(folder);  // takes ownership
  const auto check = [&](const aiScene* scene) {
    if (!folder->refused().empty()) {
      throw base::InputError(
          fmt::format("{}: names {:?}, which is not a file in the folder of the mesh or below it",
                      file.string(), folder->refused()));
    }
    if (scene != nullptr && scene->mRootNode != nullptr) return scene;
    throw base::InputError(fmt::format("{}: cannot be read as OFF, OBJ, STL, PLY or glTF ({})",
                                       file.string(), importer.GetErrorString()));
  };
  // The text form of glTF refers to files in its folder.
  const aiScene* scene =
      check(base::EndingOf(file) == ".gltf"
                ? importer.ReadFile(file.string(), 0)
                : importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, ending.c_str()));
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) Check(file, *scene->mMeshes[m]);
  if (CorrectFlags(*scene)) check(importer.ApplyPostProcessing(aiProcess_Triangulate));
  if (!textured) {
    scene = check(
        importer.ApplyPostProcessing(aiProcess_RemoveComponent | aiProcess_JoinIdenticalVertices));
  }
  const bool coordinates =
      std::ranges::any_of(std::span(scene->mMeshes, scene->mNumMeshes),
                          [](const aiMesh* mesh) { return mesh->HasTextureCoords(0); });
  TexturedMesh result;
  Collect(*scene, *scene->mRootNode, base::Pose::Identity(), result);
  if (result.mesh.triangles.empty()) throw base::InputError(file.string() + ": has no triangles");
  if (!coordinates) result.uv.clear();
  return result;
}

}  // namespace

bool PlyHoldsMesh(const std::filesystem::path& file) {
  const std::string bytes = base::ReadNonEmptyFile(file);
  return internal::IsPly(file, bytes) && internal::CheckPlyHeader(file, bytes) > 0;
}

TexturedMesh ReadTexturedMesh(const std::filesystem::path& file) {
  std::string bytes = base::ReadNonEmptyFile(file);
  // Also reports an error in the file with its line.
  const auto polygons = ReadPolygons(file, bytes);
  if (base::EndingOf(file) != ".off") return Read(file, std::move(bytes), true);
  return {internal::ToPolygonMesh(file, *polygons).mesh, {}};
}

PolygonMesh ReadPolygonMesh(const std::filesystem::path& file) {
  std::string bytes = base::ReadNonEmptyFile(file);
  if (const auto polygons = ReadPolygons(file, bytes)) {
    return internal::ToPolygonMesh(file, *polygons);
  }
  PolygonMesh result{Read(file, std::move(bytes), false).mesh, {}, 0};
  result.polygons = result.mesh.triangles.size();
  result.polygon.resize(result.polygons);
  std::iota(result.polygon.begin(), result.polygon.end(), 0U);
  return result;
}

TriangleMesh ReadMesh(const std::filesystem::path& file) { return ReadPolygonMesh(file).mesh; }

void WriteStl(const std::filesystem::path& file, const TriangleMesh& mesh) {
  constexpr std::size_t kHeader_bytes = 80;  // of the format; its text has no meaning
  std::string bytes(kHeader_bytes, ' ');
  internal::AppendRaw(static_cast<std::uint32_t>(mesh.triangles.size()), bytes);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& p = mesh.vertices[a];
    internal::AppendPoint((mesh.vertices[b] - p).cross(mesh.vertices[c] - p).normalized(), bytes);
    for (const std::uint32_t vertex : {a, b, c}) {
      internal::AppendPoint(mesh.vertices[vertex], bytes);
    }
    internal::AppendRaw(std::uint16_t{0}, bytes);
  }
  base::WriteFile(file, bytes);
}

void WriteColoredPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                     const std::vector<std::array<std::uint8_t, 3>>& colors) {
  if (colors.size() != mesh.vertices.size()) {
    throw std::invalid_argument(fmt::format("WriteColoredPly: {} colours for {} vertices",
                                            colors.size(), mesh.vertices.size()));
  }
  std::string bytes =
      internal::PlyVertexHeader(mesh.vertices.size()) + internal::kPlyColor +
      fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                  mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    internal::AppendPoint(mesh.vertices[i], bytes);
    for (const std::uint8_t channel : colors[i]) internal::AppendRaw(channel, bytes);
  }
  for (const auto& triangle : mesh.triangles) {
    internal::AppendRaw(std::uint8_t{3}, bytes);
    for (const std::uint32_t vertex : triangle) {
      internal::AppendRaw(static_cast<std::int32_t>(vertex), bytes);
    }
  }
  base::WriteFile(file, bytes);
}

}  // namespace rangegrasp::geometry
