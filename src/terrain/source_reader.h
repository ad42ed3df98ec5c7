#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "base/patient_caller.h"
#include "io/raster.h"

namespace nepho {

/// What became of the blocks of one raster.
struct SourceStats {
  std::string path;
  uint64_t read = 0;       ///< blocks read from the raster itself
  uint64_t averaged = 0;   ///< made from finer ones
  uint64_t from_disk = 0;  ///< read from the disk cache
  uint64_t retried = 0;    ///< reads that failed and were tried again
  uint64_t failed = 0;     ///< blocks that could not be read, and show what lies below
  bool given_up = false;   ///< it does not answer, or nothing but errors: not read any more
  std::string failure;     ///< the first one, as it was warned of; empty: none
};

/// A raster that may fail: a read that does not succeed is tried again twice, after pauses (those of the same source on
/// other threads go on meanwhile). A source that does not come back within the timeout, or answers with nothing but
/// errors for as long, is given up: all later reads fail at once. One warning, at the first failure, where what is
/// missing may be left out. All that read one source share one of these. Thread-safe.
class SourceReader final : public Raster {
 public:
  /// Whether those who read make do without what is missing, or fail with its message.
  enum class Missing { left_out, fatal };
  /// `timeout_s`: 0 waits for ever.
  SourceReader(std::shared_ptr<Raster> raster, double timeout_s, Missing missing = Missing::left_out);
  /// `raster` itself where it is one already.
  static std::shared_ptr<SourceReader> of(std::shared_ptr<Raster> raster, double timeout_s,
                                          Missing missing = Missing::left_out);

  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override { return raster_->reductions(); }
  uint32_t pyramid_level(uint32_t reduction) const override { return raster_->pyramid_level(reduction); }
  /// Blocks of any other size than they should have, and exceptions, are failures too.
  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override;

  /// False once it was given up.
  bool may_be_read() const { return !given_up_ && !caller_.given_up(); }
  /// The reads and failures.
  SourceStats stats() const;

 private:
  Result<RasterBlock> read_once(uint32_t reduction, uint32_t bx, uint32_t by, double& waited_s) const;
  void succeeded() const;
  void failed(const std::string& reason, double waited_s) const;

  std::shared_ptr<Raster> raster_;
  RasterInfo info_;
  PatientCaller caller_;
  Missing missing_;
  mutable std::atomic<uint64_t> read_{0}, retried_{0}, failed_{0};
  mutable std::atomic<uint32_t> failures_in_row_{0};
  mutable std::atomic<bool> given_up_{false};
  mutable std::mutex failure_mutex_;
  mutable double failing_s_ = 0.0;  // waited for errors since the last success
  mutable std::string failure_;     // the first
};

}  // namespace nepho
