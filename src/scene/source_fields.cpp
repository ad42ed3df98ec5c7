#include "scene/source_fields.h"

#include "scene/field_ranges.h"

namespace nepho {

namespace {

// A zoom of 22 with tiles of 256 px is 2^30 pixels around the Earth, 4 cm each.
const Range kZooms = closed(0, 22);
constexpr size_t kMostSources = 256;

template <typename Source>
void describe_path(FieldVisitor& v, Source& p) {
  v.leaf({.name = "path",
          .doc = "file, folder of files, tiles (folder or URL with {z}, {x} and {y} or {-y}) or GDAL connection "
                 "(docs/data.md); relative to the scene file",
          .text = TextKind::file},
         &p.path);
  v.leaf({.name = "order",
          .doc = "lower ones lie below higher ones; among equals later ones of the list lie over earlier ones",
          .range = closed(-1e6, 1e6)},
         &p.order);
}

template <typename Source>
void describe_zooms(FieldVisitor& v, Source& p, const std::string& of_url) {
  v.leaf({.name = "min_zoom", .doc = "tiles: the coarsest zoom there is", .range = kZooms}, &p.min_zoom);
  v.leaf({.name = "max_zoom",
          .doc = "tiles: the finest zoom there is; -1: the finest that a folder has, " + of_url + " of a URL",
          .range = closed(-1, kZooms.max)},
         &p.max_zoom);
}

template <typename Source>
void describe_list(FieldVisitor& v, const Field& field, std::vector<Source>& stack) {
  v.items(field, {.max = kMostSources,
                  .shorthand = "path",
                  .size = [&stack] { return stack.size(); },
                  .resize = [&stack](size_t n) { stack.assign(n, {}); },
                  .visit = [&stack](FieldVisitor& visitor, size_t i) { describe(visitor, stack[i]); },
                  .visit_default =
                      [](FieldVisitor& visitor) {
                        Source defaults;
                        describe(visitor, defaults);
                      }});
}

}  // namespace

void describe(FieldVisitor& v, ElevationSource& p) {
  describe_path(v, p);
  v.leaf({.name = "opacity",
          .doc = "share of its heights in the result where it has data; the rest is what lies below",
          .range = share()},
         &p.opacity);
  v.leaf({.name = "vertical_datum",
          .doc = "what its heights are above; auto: what its CRS says, else egm96 (mean sea level)",
          .term = "vertical datum",
          .choices = {"auto", "ellipsoid", "egm96"}},
         &p.vertical_datum);
  v.leaf({.name = "vertical_scale",
          .doc = "multiplies its heights; above 1 exaggerates, -1 turns depths into heights",
          .range = closed(-1000, 1000),
          .term = "vertical exaggeration"},
         &p.vertical_scale);
  v.leaf({.name = "encoding",
          .doc = "heights in the colours of a picture; auto: by its numbers where it has three bands of 8 bits",
          .choices = {"auto", "none", "terrarium", "mapbox"}},
         &p.encoding);
  describe_zooms(v, p, "15");
}

void describe(FieldVisitor& v, ImagerySource& p) {
  describe_path(v, p);
  v.leaf({.name = "opacity", .doc = "multiplies its alpha; the rest is what lies below", .range = share()}, &p.opacity);
  v.leaf({.name = "gamma",
          .doc = "brightness = number^(1/gamma): above 1 the middle tones are lighter",
          .range = closed(0.05, 20)},
         &p.gamma);
  v.leaf({.name = "albedo_scale",
          .doc = "multiplies the albedo, which is the linear value of its sRGB colour and at most 1 in the end",
          .range = closed(0, 100),
          .term = "albedo"},
         &p.albedo_scale);
  v.leaf({.name = "stretch",
          .doc = "which numbers become black and white; auto: 8 bits as they are, others by percentiles 1 and 99; "
                 "none: the full range of the data type"},
         &p.stretch);
  describe_zooms(v, p, "19");
}

void describe_stack(FieldVisitor& v, const Field& field, std::vector<ElevationSource>& stack) {
  describe_list(v, field, stack);
}
void describe_stack(FieldVisitor& v, const Field& field, std::vector<ImagerySource>& stack) {
  describe_list(v, field, stack);
}

}  // namespace nepho
