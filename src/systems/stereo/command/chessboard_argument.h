#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "stereo/calibrate.h"

namespace rangegrasp::cli {

/// The chessboard as the command line names it.
struct ChessboardArgument {
  std::string corners = "9x6";
  double square_mm = 25.0;
};

/// --corners and --square-mm. The argument must outlive the command.
void AddBoardOptions(CLI::App& command, ChessboardArgument& argument);
/// @throws base::InputError naming the option that is no board.
stereo::ChessboardOptions BoardOf(const ChessboardArgument& argument);

}  // namespace rangegrasp::cli
