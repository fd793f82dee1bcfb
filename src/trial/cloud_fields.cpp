#include "trial/cloud_fields.h"

namespace rangegrasp::trial {

std::vector<geometry::CloudField> TruthFields(const geometry::View& view,
                                              const sensing::ScanTruth& truth) {
  geometry::CloudField label{"label", truth.label};
  geometry::CloudField state{"state", {}};
  for (const auto s : truth.state) state.values.push_back(static_cast<std::uint32_t>(s));
  std::vector<geometry::CloudField> fields = {label, state};
  if (!view.colors.empty()) fields.push_back(geometry::ColorField(view.colors));
  return fields;
}

}  // namespace rangegrasp::trial
