#ifndef NEPHO_COMMON_PIXEL_TILES_H
#define NEPHO_COMMON_PIXEL_TILES_H
#include "common/shared.h"
SHARED_BEGIN
// Side of the tiles that a picture is drawn in, px. On a software device every group costs about a microsecond: larger tiles
// are quicker there, smaller ones mix sky and surface less.
SHARED_CONST int kPixelTile = 16;
SHARED_END
#endif
