#include "terrain/source_reader.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "base/log.h"
#include "base/seconds_since.h"

namespace nepho {

namespace {

constexpr double kPauses_s[] = {0.05, 0.25};
/// After this many failed blocks in a row no time is lost with trying again.
constexpr uint32_t kFailuresInRow = 3;
/// After this many even a tenth of the timeout spent on nothing but errors is enough.
constexpr uint32_t kManyFailures = 64;
/// A read that computed for longer than this failed on its data; another try would compute the same.
constexpr double kHardWork_s = 0.25;

/// A raster that is not closed any more once some call has been left behind: closing it might wait for a lock that the
/// call holds. The program is about to end then.
std::shared_ptr<Raster> closed_only_if_safe(std::shared_ptr<Raster> raster) {
  Raster* const plain = raster.get();
  return {plain, [raster = std::move(raster)](Raster*) mutable {
            if (calls_left_behind()) (void)new std::shared_ptr<Raster>(std::move(raster));
          }};
}

}  // namespace

SourceReader::SourceReader(std::shared_ptr<Raster> raster, double timeout_s, Missing missing)
    : raster_(closed_only_if_safe(std::move(raster))), info_(raster_->info()), caller_(timeout_s), missing_(missing) {}

std::shared_ptr<SourceReader> SourceReader::of(std::shared_ptr<Raster> raster, double timeout_s, Missing missing) {
  if (auto reader = std::dynamic_pointer_cast<SourceReader>(raster)) return reader;
  return std::make_shared<SourceReader>(std::move(raster), timeout_s, missing);
}

Result<RasterBlock> SourceReader::read_block(uint32_t reduction, uint32_t bx, uint32_t by) const {
  const uint32_t tries = failures_in_row_ >= kFailuresInRow ? 1 : 1 + std::size(kPauses_s);
  std::string reason;
  double waited_s = 0.0;
  for (uint32_t i = 0; i < tries && may_be_read(); ++i) {
    if (i > 0) {
      ++retried_;
      std::this_thread::sleep_for(std::chrono::duration<double>(kPauses_s[i - 1]));
    }
    const auto start = std::chrono::steady_clock::now();
    double call_s = 0.0;
    Result<RasterBlock> block = read_once(reduction, bx, by, call_s);
    if (block) {
      succeeded();
      return block;
    }
    reason = block.reason();
    waited_s += call_s;
    if (seconds_since(start) - call_s > kHardWork_s) break;
  }
  failed(reason, waited_s);
  return Result<RasterBlock>::failed(reason.empty() ? fmt::format("{}: was given up", info_.path) : reason);
}

Result<RasterBlock> SourceReader::read_once(uint32_t reduction, uint32_t bx, uint32_t by, double& waited_s) const {
  try {
    // Owns the raster: the call may outlive this object.
    std::optional<Result<RasterBlock>> result = caller_.call(
        [raster = raster_, reduction, bx, by] { return raster->read_block(reduction, bx, by); }, &waited_s);
    if (!result)
      return Result<RasterBlock>::failed(
          fmt::format("{}: does not answer within {:.3g} s", info_.path, caller_.patience_s()));
    ++read_;
    if (!*result) return *result;
    const auto reduced = [&](uint32_t size) { return (size + (uint64_t{1} << reduction) - 1) >> reduction; };
    const RasterBlock& block = **result;
    const uint64_t width = std::min<uint64_t>(kBlockSize, reduced(info_.width) - uint64_t{bx} * kBlockSize);
    const uint64_t height = std::min<uint64_t>(kBlockSize, reduced(info_.height) - uint64_t{by} * kBlockSize);
    if (block.width == width && block.height == height && block.valid.size() == width * height &&
        block.values.size() == width * height * info_.bands)
      return std::move(*result);
    return Result<RasterBlock>::failed(fmt::format("{}: delivers blocks of another size than it should", info_.path));
  } catch (const std::exception& e) {
    return Result<RasterBlock>::failed(fmt::format("{}: {}", info_.path, e.what()));
  }
}

void SourceReader::succeeded() const {
  failures_in_row_ = 0;
  const std::lock_guard lock(failure_mutex_);
  failing_s_ = 0.0;
}

void SourceReader::failed(const std::string& reason, double waited_s) const {
  ++failed_;
  const uint32_t in_row = ++failures_in_row_;
  const std::lock_guard lock(failure_mutex_);
  failing_s_ += waited_s;
  const double most_s = in_row >= kManyFailures ? 0.1 * caller_.patience_s() : caller_.patience_s();
  if (caller_.patience_s() > 0.0 && failing_s_ > most_s) given_up_ = true;
  if (!failure_.empty() || reason.empty()) return;
  failure_ = reason;
  if (missing_ == Missing::fatal) return;
  log_warning("{}; {}", reason,
              caller_.given_up() ? "it is left out from here on" : "what lies below shows in such places");
}

SourceStats SourceReader::stats() const {
  SourceStats s;
  s.path = info_.path;
  s.read = read_;
  s.retried = retried_;
  s.failed = failed_;
  s.given_up = !may_be_read();
  const std::lock_guard lock(failure_mutex_);
  s.failure = failure_;
  return s;
}

}  // namespace nepho
