#include "stereo/command/chessboard_argument.h"

#include <cstdio>

#include "base/error.h"
#include "base/units.h"

namespace rangegrasp::cli {

void AddBoardOptions(CLI::App& command, ChessboardArgument& argument) {
  command.add_option("--corners", argument.corners, "inner corners of the board (9x6)");
  command.add_option("--square-mm", argument.square_mm, "edge of its squares (25)")
      ->check(CLI::Range(1.0, 1000.0));
}

stereo::ChessboardOptions BoardOf(const ChessboardArgument& argument) {
  stereo::ChessboardOptions board;
  int used = 0;
  const std::string& text = argument.corners;
  if (std::sscanf(text.c_str(), "%dx%d%n", &board.columns, &board.rows, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || board.columns < 3 || board.rows < 3) {
    throw base::InputError("--corners '" + text +
                           "' must be COLUMNSxROWS inner corners, 3 each at least, e.g. 9x6");
  }
  board.square_m = argument.square_mm * base::kMm;
  return board;
}

}  // namespace rangegrasp::cli
