#include "rasters/pixel_to_lon_lat.h"

#include <cpl_string.h>
#include <gdal_alg.h>
#include <ogr_spatialref.h>

namespace nepho {

PixelToLonLat::PixelToLonLat(GDALDataset& dataset, bool assume_degrees) {
  CPLStringList options;
  options.SetNameValue("DST_SRS", SRS_WKT_WGS84_LAT_LONG);
  if (assume_degrees) options.SetNameValue("SRC_SRS", SRS_WKT_WGS84_LAT_LONG);
  transformer_ = GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(&dataset), nullptr, options.List());
}

PixelToLonLat::~PixelToLonLat() {
  if (transformer_) GDALDestroyGenImgProjTransformer(transformer_);
}

bool PixelToLonLat::transform(int to_pixels, double& x, double& y) const {
  double z = 0.0;
  int good = FALSE;
  GDALGenImgProjTransform(transformer_, to_pixels, 1, &x, &y, &z, &good);
  return good && std::isfinite(x) && std::isfinite(y);
}

bool needs_assumed_degrees(GDALDataset& dataset) {
  return dataset.GetGCPCount() > 0 && !dataset.GetGCPSpatialRef() && !dataset.GetSpatialRef();
}

std::string crs_name(const OGRSpatialReference& srs) {
  const char* name = srs.GetName();
  return name ? name : "unnamed";
}

}  // namespace nepho
