#pragma once
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace nepho {

/// Calls things that may never come back, such as a read from a drive that is gone. Each call runs on a thread of its
/// own while the caller waits. A call is given up when for `patience_s` neither it nor another call of this object came
/// back or was seen at work: used a hundredth of the time of a processor. From then on no call is made any more. The
/// thread stays behind with all that the call holds, which must therefore own what it uses. Thread-safe.
class PatientCaller {
 public:
  /// `patience_s`: > 0; 0 waits for ever, on the caller's own thread.
  explicit PatientCaller(double patience_s) : patience_s_(patience_s) {}

  /// What `work` returns; nothing when it was given up. Rethrows what it throws. `waited_s`: how long the call did not
  /// use the processor, s.
  template <typename F>
  std::optional<std::invoke_result_t<F>> call(F work, double* waited_s = nullptr) const {
    using R = std::invoke_result_t<F>;
    struct Outcome {
      std::optional<R> value;
      std::exception_ptr error;
    };
    const auto outcome = std::make_shared<Outcome>();
    const bool back = run(
        [outcome, work = std::move(work)]() mutable {
          try {
            outcome->value.emplace(work());
          } catch (...) {
            outcome->error = std::current_exception();
          }
        },
        waited_s);
    if (!back) return std::nullopt;
    if (outcome->error) std::rethrow_exception(outcome->error);
    return std::move(outcome->value);
  }
  double patience_s() const { return patience_s_; }
  bool given_up() const { return given_up_; }

 private:
  bool run(std::function<void()> work, double* waited_s) const;

  double patience_s_;
  mutable std::atomic<bool> given_up_{false};
  mutable std::atomic<int64_t> last_sign_ns_{0};  // of life, on the steady clock
};

/// Whether a call that was given up has not come back to this moment. Its thread may hold locks of libraries: a program
/// then ends with std::_Exit() after it has written everything, or its clean-up might wait for ever.
bool calls_left_behind();

}  // namespace nepho
