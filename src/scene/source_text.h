#pragma once
#include <string>

#include "scene/source_params.h"

namespace nepho {

/// An entry of a stack from the command line: "PATH[,key=value]...", keys as in a scene file
/// ("a.tif,opacity=0.5,stretch=0:4000"). The settings begin at the first comma that is followed by a known key and '=';
/// other commas belong to the path. `label` is the option, for messages. Throws Error(usage): a key that is unknown, or
/// that looks like a known one misspelt where no file has that name; a bad value.
ElevationSource parse_elevation_source(const std::string& text, const std::string& label);
ImagerySource parse_imagery_source(const std::string& text, const std::string& label);

}  // namespace nepho
