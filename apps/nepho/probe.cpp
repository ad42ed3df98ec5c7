#include "probe.h"

#include "probe_tables.h"

namespace nepho {

namespace {
const std::vector<ProbeKind>& probe_kinds() {
  static const std::vector<ProbeKind> kinds = [] {
    std::vector<ProbeKind> all;
    for (const auto& subject : {geo_probe_kinds(), astro_probe_kinds(), atmosphere_probe_kinds(), cloud_probe_kinds(),
                                slab_probe_kinds(), terrain_probe_kinds()})
      all.insert(all.end(), subject.begin(), subject.end());
    return all;
  }();
  return kinds;
}
}  // namespace

std::vector<std::string> probe_kind_names() {
  std::vector<std::string> names;
  for (const ProbeKind& kind : probe_kinds()) names.push_back(kind.name);
  return names;
}

int run_probe(const std::string& kind, std::istream& in, std::ostream& out, const ProbeOptions& options) {
  for (const ProbeKind& known : probe_kinds()) {
    if (known.name != kind) continue;
    const ProbeTable table(kind, known.inputs, read_csv(in));
    table.write(out, known.evaluate(table, options));
    return 0;
  }
  const std::vector<std::string> names = probe_kind_names();
  const std::string near = nearest_name(kind, names);
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  throw fail(ErrorKind::usage, "probe '{}': there is no such kind{}; known: {}", kind,
             near.empty() ? std::string() : fmt::format("; did you mean '{}'?", near), list);
}

}  // namespace nepho
