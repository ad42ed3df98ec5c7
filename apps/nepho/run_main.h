#pragma once
#include "nepho/raster_access.h"

namespace nepho {

/// All of main(): the commands, with the library behind them. Returns the exit status; throws nothing.
int run_main(int argc, char** argv, const RasterAccess& rasters);

}  // namespace nepho
