#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

#include "base/error.h"

namespace rangegrasp::testing_support {

/// What the error says that an action ends in; nothing if it ends well. Another error is a failure
/// of the test.
template <typename Error = base::InputError>
std::string MessageOf(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another error: " << error.what();
  }
  return "";
}

/// The same of an action that must end in an error: it is a failure of the test if it does not.
template <typename Error = base::InputError>
std::string ErrorOf(const auto& action) {
  const std::string message = MessageOf<Error>(action);
  EXPECT_NE(message, "") << "no error";
  return message;
}

}  // namespace rangegrasp::testing_support
