#include "sim/check/check.h"

#include <algorithm>

#include "base/error.h"
#include "sim/check/internal/model.h"

namespace rangegrasp::check {
namespace {

constexpr int kFewestOfAnArm = 5;  // joints in a chain, of a file that says nothing else

// What the engine or a loader says, without the file's name, which stands before it.
base::Finding Told(const std::filesystem::path& mjcf, std::string what) {
  const std::string file = mjcf.string() + ": ";
  if (what.starts_with(file)) what = what.substr(file.size());
  while (!what.empty() && what.back() == '\n') what.pop_back();
  return {true, mjcf.string(), "", what, ""};
}

}  // namespace

Kind KindOf(const std::filesystem::path& mjcf) {
  const internal::SourceLines lines(mjcf);
  const auto has = [&](const char* what) { return lines.seen().contains(what); };
  if (has("site workspace")) return Kind::kScene;
  if (has("tuple arm_joints")) return Kind::kArm;
  if (has("freejoint")) return Kind::kObject;
  if (has("tuple hand_joints") || has("tuple hand_motors")) return Kind::kHand;
  if (lines.longest_chain() >= kFewestOfAnArm) return Kind::kArm;
  return lines.longest_chain() > 0 ? Kind::kHand : Kind::kScene;
}

std::vector<base::Finding> CheckModel(const std::filesystem::path& mjcf, Kind kind) {
  std::vector<base::Finding> findings;
  try {
    internal::Model model(mjcf, kind);
    CheckNames(model);
    CheckArm(model);
    CheckHand(model);
    CheckBodies(model);
    CheckContacts(model);
    CheckCell(model);
    try {
      CheckMotion(model);
    } catch (const base::InputError& error) {
      const base::Finding told = Told(mjcf, error.what());
      model.Error(told.where, told.element, told.what, told.cure);
    }
    findings = model.findings();
  } catch (const base::InputError& error) {
    findings.push_back(Told(mjcf, error.what()));
  }
  std::stable_partition(findings.begin(), findings.end(),
                        [](const base::Finding& finding) { return finding.error; });
  return findings;
}

}  // namespace rangegrasp::check
