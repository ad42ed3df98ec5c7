#pragma once
#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace nepho {

/// Whose fault a failure is; the value is the exit status of the `nepho` program.
enum class ErrorKind {
  usage = 2,    ///< an option, a place, a value out of range
  input = 3,    ///< a bad or missing input file: raster, scene, tour, unknown key
  device = 4,   ///< no usable Vulkan device
  failure = 5,  ///< anything else, such as an output that cannot be written
  interrupted = 130,  ///< by a signal; what there was is written
};

/// A failure that ends the work in hand. The message is one line that names the thing, what was found, and what helps.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }
  int exit_status() const { return static_cast<int>(kind_); }

 private:
  ErrorKind kind_;
};

/// `throw fail(ErrorKind::input, "{}: not a raster", path)` with fmt formatting.
template <typename... Args>
[[nodiscard]] Error fail(ErrorKind kind, fmt::format_string<Args...> format, Args&&... args) {
  return Error(kind, fmt::format(format, std::forward<Args>(args)...));
}

/// Data that is often imperfect (tiles, weather files): a value with warnings, or a reason why there is none.
template <typename T>
class Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  static Result failed(std::string reason) {
    Result r;
    r.reason_ = std::move(reason);
    return r;
  }
  explicit operator bool() const { return value_.has_value(); }
  const T& operator*() const { return *value_; }
  T& operator*() { return *value_; }
  const T* operator->() const { return &*value_; }
  T* operator->() { return &*value_; }
  const std::string& reason() const { return reason_; }                 ///< empty when there is a value
  const std::vector<std::string>& warnings() const { return warnings_; }  ///< one line each
  void warn(std::string line) { warnings_.push_back(std::move(line)); }
  /// The value, or an Error of `kind` with the reason as its message.
  T take_or_throw(ErrorKind kind) {
    if (!value_) throw Error(kind, reason_);
    return std::move(*value_);
  }

 private:
  Result() = default;
  std::optional<T> value_;
  std::string reason_;
  std::vector<std::string> warnings_;
};

/// The known name nearest to `wanted` by edit distance, for "did you mean" hints; empty when nothing is near.
std::string nearest_name(const std::string& wanted, const std::vector<std::string>& known);

[[noreturn]] void assert_failed(const char* expression, const char* file, int line, const std::string& values);

namespace detail {
template <typename A, typename B>
std::string both_values(const A& a, const B& b) {
  return fmt::format("{} vs {}", a, b);
}
}  // namespace detail
}  // namespace nepho

/// Our own mistakes. Always on: prints the expression and aborts.
#define NEPHO_ASSERT(expr)                                             \
  do {                                                                 \
    if (!(expr)) ::nepho::assert_failed(#expr, __FILE__, __LINE__, ""); \
  } while (false)

/// As NEPHO_ASSERT(a op b), but prints both values.
#define NEPHO_ASSERT_OP(a, op, b)                                                                                \
  do {                                                                                                           \
    if (!((a)op(b))) ::nepho::assert_failed(#a " " #op " " #b, __FILE__, __LINE__, ::nepho::detail::both_values((a), (b))); \
  } while (false)
