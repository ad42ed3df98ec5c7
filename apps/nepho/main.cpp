// nepho: the program with GDAL behind its rasters.
#include <gdal_version.h>

#include "nepho/run_main.h"
#include "rasters/gdal_opener.h"

int main(int argc, char** argv) {
  return nepho::run_main(argc, argv,
                         {.opener = nepho::make_gdal_opener(),
                          .find_default_earth = nepho::find_default_earth,
                          .gdal_version = GDAL_RELEASE_NAME});
}
