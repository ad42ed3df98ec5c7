#pragma once
#include <iosfwd>

namespace nepho {

struct RasterAccess;

/// `nepho info`: version, Vulkan devices, data found, named places, versions of libraries. As text or as one JSON
/// object.
void print_info(bool as_json, std::ostream& out, const RasterAccess& rasters);

}  // namespace nepho
