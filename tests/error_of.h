#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

#include "base/error.h"

namespace rangegrasp::testing_support {

/// The message of the error that an action throws; empty if it throws none. An error of another
/// type fails the test.
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

/// As MessageOf, but the test fails if the action throws no error.
template <typename Error = base::InputError>
std::string ErrorOf(const auto& action) {
  const std::string message = MessageOf<Error>(action);
  EXPECT_NE(message, "") << "no error";
  return message;
}

}  // namespace rangegrasp::testing_support
