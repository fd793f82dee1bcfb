#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// Each adds its commands to the program and stands in the source of its name (AddRunCommand in
/// run_command.cpp); a command's callback does the work and throws core::InputError or
/// core::RunError.
void AddAddObjectCommand(CLI::App& app);         ///< add-object
void AddBringCommand(CLI::App& app);             ///< bring
void AddCalibrateHandEyeCommand(CLI::App& app);  ///< calibrate-hand-eye
void AddCalibrateStereoCommand(CLI::App& app);   ///< calibrate-stereo
void AddCheckCommand(CLI::App& app);             ///< check
void AddCylindersCommand(CLI::App& app);         ///< cylinders
void AddExportCommand(CLI::App& app);            ///< export
void AddLearnCommand(CLI::App& app);             ///< learn
void AddListCommand(CLI::App& app);              ///< list
void AddPartsCommands(CLI::App& app);            ///< parts FILE
void AddPerceiveCommand(CLI::App& app);          ///< perceive
void AddRecognizeCommand(CLI::App& app);         ///< recognize
void AddPictureCommands(CLI::App& app);          ///< snapshot, scan
void AddReproduceCommand(CLI::App& app);         ///< reproduce
void AddReportCommand(CLI::App& app);            ///< report
void AddResultsCommands(CLI::App& app);          ///< table, trial, compare, merge
void AddRunCommand(CLI::App& app);               ///< run
void AddSeamCommands(CLI::App& app);             ///< seam generate, calibrate, detect
void AddShellCommands(CLI::App& app);            ///< completion, man
void AddSlurmCommands(CLI::App& app);            ///< submit, status
void AddStereoCommand(CLI::App& app);            ///< stereo
void AddVersionCommand(CLI::App& app);           ///< version

}  // namespace rangegrasp::cli
