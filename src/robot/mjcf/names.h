#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::mjcf {

/// What follows the last '/' of a name.
std::string_view Suffix(std::string_view name);

/// How many elements of a type a model has; 0 of types that have no names here.
int CountOf(const mjModel* model, mjtObj type);

/// The first element of a type whose name ends so; -1 if there is none.
int TryFind(const mjModel* model, mjtObj type, std::string_view suffix);
/// @throws base::InputError naming the element and those that exist.
int Find(const mjModel* model, mjtObj type, std::string_view suffix);

/// The elements of a custom tuple. @throws base::InputError if it is missing or holds another type.
std::vector<int> TupleOf(const mjModel* model, mjtObj type, std::string_view suffix);
/// A custom numeric; empty if there is none.
std::vector<double> NumericOf(const mjModel* model, std::string_view suffix);

/// True for `body` and all below it.
bool InSubtree(const mjModel* model, int body, int root);

}  // namespace rangegrasp::mjcf
