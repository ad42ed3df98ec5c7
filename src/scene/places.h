#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"

namespace nepho {

/// A view of data/places.json: its camera, and a time at which the sun stands well there.
struct Place {
  std::string name;   ///< as given to --place
  std::string title;  ///< one line for people
  CameraParams camera;
  std::string time;  ///< canonical UTC
};

/// All named places, in the order of the file. Throws Error(input) when the file is missing or wrong.
std::vector<Place> named_places();

/// The place of that name. Throws Error(usage) naming the nearest name and all of them.
Place find_place(const std::string& name);

}  // namespace nepho
