#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

#include "core/error.h"

namespace rangegrasp::testing_support {

/// What the error says that an action ends in; nothing if it ends well. Another error is a failure
/// of the test.
template <typename Error = core::InputError>
std::string ErrorOf(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another error: " << error.what();
  }
  return "";
}

}  // namespace rangegrasp::testing_support
