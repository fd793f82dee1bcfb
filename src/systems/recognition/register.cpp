#include "cli/commands.h"
#include "experiment/kinds.h"
#include "recognition/bring/bring_task.h"
#include "recognition/command/recognition_commands.h"
#include "recognition/task/recognition_task.h"
#include "recognition/views/looker.h"
#include "trial/registry.h"

namespace rangegrasp {
namespace {

std::vector<std::filesystem::path> FilesOf(const trial::Options& options) {
  const auto looks = trial::Of<views::LookOptions>(options, views::kLooks);
  std::vector<std::filesystem::path> files;
  for (const auto& file : {looks.sensor, looks.hand_eye}) {
    if (!file.empty()) files.push_back(file);
  }
  return files;
}

}  // namespace

void RegisterRecognition() {
  experiment::AddKind(bring::BringTask());
  experiment::AddKind(recognition_task::RecognitionTask());
  trial::AddKeyReader([](base::YamlMap& map, trial::Options& options) {
    views::ReadLookOptions(map, trial::Of<views::LookOptions>(options, views::kLooks));
  });
  trial::AddFileList(FilesOf);
  trial::SetFurtherLooks({.wanted =
                              [](const trial::Options& options) {
                                return trial::Of<views::LookOptions>(options, views::kLooks).views >
                                       1;
                              },
                          .look = views::LookAround});
  cli::AddCommand(cli::AddBringCommand);
  cli::AddCommand(cli::AddLearnCommand);
  cli::AddCommand(cli::AddRecognizeCommand);
}

}  // namespace rangegrasp
