#include <doctest/doctest.h>

#include <algorithm>

#include "base/error.h"
#include "gpu/frame_graph_compile.h"

using namespace nepho;
using gpu::CompiledGraph;

namespace {
const ImageDesc kSmall{.extent = {8, 8}, .format = Format::rgba16f};

const gpu::CompiledBarrier* barrier_before(const CompiledGraph& g, const FrameGraph& graph, const std::string& pass,
                                           ImageRef image) {
  for (const gpu::CompiledPass& p : g.passes)
    if (graph.passes()[p.pass].name == pass)
      for (const gpu::CompiledBarrier& b : p.barriers)
        if (b.slot.resource == image.index) return &b;
  return nullptr;
}
}  // namespace

TEST_CASE("frame graph: a pass whose outputs are unused is culled, and so is what only it needs") {
  FrameGraph graph;
  const ImageRef a = graph.create("a", kSmall), b = graph.create("b", kSmall), out = graph.create("out", kSmall);
  graph.pass("feeds_unused").write("x", a).record({});
  graph.pass("unused").sample("x", a).write("y", b).record({});
  graph.pass("used").write("z", out).record({});
  graph.keep(out);
  const CompiledGraph g = gpu::compile(graph);
  REQUIRE(g.passes.size() == 1);
  CHECK(graph.passes()[g.passes[0].pass].name == "used");
  CHECK(g.culled == std::vector<std::string>{"feeds_unused", "unused"});
}

TEST_CASE("frame graph: compute write then sample gets one barrier with stages, accesses and layouts of both") {
  FrameGraph graph;
  const ImageRef a = graph.create("a", kSmall), out = graph.create("out", kSmall);
  graph.pass("write").write("x", a).record({});
  graph.pass("read").sample("x", a).write("y", out).record({});
  graph.keep(out);
  const CompiledGraph g = gpu::compile(graph);
  const gpu::CompiledBarrier* b = barrier_before(g, graph, "read", a);
  REQUIRE(b != nullptr);
  CHECK(b->from.stages == VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
  CHECK(b->from.access == VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  CHECK(b->from.layout == VK_IMAGE_LAYOUT_GENERAL);
  CHECK(b->to.access == VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  CHECK(b->to.layout == VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  CHECK_FALSE(b->discard);
  const gpu::CompiledBarrier* first = barrier_before(g, graph, "write", a);
  REQUIRE(first != nullptr);
  CHECK(first->first_use);
  CHECK(first->discard);
}

TEST_CASE("frame graph: a second reader in another stage widens the first barrier instead of adding one") {
  FrameGraph graph;
  const ImageRef a = graph.create("a", kSmall), out = graph.create("out", kSmall),
                 target = graph.create("target", kSmall);
  graph.pass("write").write("x", a).record({});
  graph.pass("read").sample("x", a).write("y", out).record({});
  graph.pass("draw").sample("x", a).color(target).record({});
  graph.keep(out);
  graph.keep(target);
  const CompiledGraph g = gpu::compile(graph);
  CHECK(barrier_before(g, graph, "draw", a) == nullptr);
  const gpu::CompiledBarrier* b = barrier_before(g, graph, "read", a);
  REQUIRE(b != nullptr);
  CHECK((b->to.stages & VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT) != 0);
  CHECK((b->to.stages & VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT) != 0);
}

TEST_CASE("frame graph: write after read waits for the readers") {
  FrameGraph graph;
  const ImageRef a = graph.create("a", kSmall), out = graph.create("out", kSmall);
  graph.pass("write").write("x", a).record({});
  graph.pass("read").sample("x", a).write("y", out).record({});
  graph.pass("again").write("x", a).record({});
  graph.keep(out);
  graph.keep(a);
  const CompiledGraph g = gpu::compile(graph);
  const gpu::CompiledBarrier* b = barrier_before(g, graph, "again", a);
  REQUIRE(b != nullptr);
  CHECK(b->from.access == VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  CHECK(b->to.access == VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
}

TEST_CASE("frame graph: transients with disjoint lifetimes and equal descriptions share memory, others do not") {
  FrameGraph graph;
  const ImageRef a = graph.create("a", kSmall), b = graph.create("b", kSmall), c = graph.create("c", kSmall),
                 d = graph.create("d", kSmall);
  graph.pass("1").write("x", a).record({});
  graph.pass("2").sample("x", a).write("y", b).record({});
  graph.pass("3").sample("x", b).write("y", c).record({});
  graph.pass("4").sample("x", c).write("y", d).record({});
  graph.keep(d);
  const CompiledGraph g = gpu::compile(graph);
  const auto physical = [&](ImageRef r) {
    return std::find_if(g.placements.begin(), g.placements.end(),
                        [&](const gpu::Placement& p) { return p.resource == r.index; })
        ->physical;
  };
  CHECK(physical(a) == physical(c));
  CHECK(physical(b) == physical(d));
  CHECK(physical(a) != physical(b));
  CHECK(g.physical_count == 2);
}

TEST_CASE("frame graph: last frame's image and this frame's are two slots, and history passes are never culled") {
  FrameGraph graph;
  const ImageRef h = graph.create_history("h", kSmall);
  graph.pass("blend").sample_history("last", h).write("now", h).record({});
  const CompiledGraph g = gpu::compile(graph);
  REQUIRE(g.passes.size() == 1);
  CHECK(g.passes[0].barriers.size() == 2);
  CHECK(g.placements.empty());
}

TEST_CASE("frame graph: mistakes are errors that name pass and resource") {
  const auto message = [](const FrameGraph& graph) {
    try {
      gpu::compile(graph);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  {
    FrameGraph graph;
    const ImageRef a = graph.create("never_written", kSmall), out = graph.create("out", kSmall);
    graph.pass("reader").sample("x", a).write("y", out).record({});
    graph.keep(out);
    const std::string text = message(graph);
    CHECK(text.find("reader") != std::string::npos);
    CHECK(text.find("never_written") != std::string::npos);
  }
  {
    FrameGraph graph;
    const ImageRef a = graph.create("both_ways", kSmall);
    graph.pass("first").write("x", a).record({});
    graph.pass("clash").sample("x", a).write("y", a).record({});
    graph.keep(a);
    CHECK(message(graph).find("both_ways") != std::string::npos);
  }
  {
    FrameGraph graph;
    graph.keep(graph.create("orphan", kSmall));
    CHECK(message(graph).find("orphan") != std::string::npos);
  }
}
