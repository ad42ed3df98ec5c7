#include "terrain/block_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <vector>

#include "base/files.h"
#include "base/give_way.h"
#include "base/log.h"
#include "terrain/block_codec.h"

namespace nepho {
namespace fs = std::filesystem;

namespace {

constexpr uint64_t kMostWaitingBytes = 64u << 20;
constexpr const char* kSuffix = ".block";
/// Temporary files of a process that was killed are removed after this time.
constexpr auto kStale = std::chrono::hours(1);

uint64_t hash_of(const std::string& text, uint64_t seed) {
  for (const char c : text) seed = (seed ^ static_cast<uint8_t>(c)) * 0x100000001b3ull;
  return seed ^ (seed >> 31);
}

/// The key in a file: what the numbers depend on, and which block it is.
std::string key_of(const BlockStore::Source& source, uint32_t reduction, uint32_t bx, uint32_t by) {
  return fmt::format("{}\n{} {} {}", source.identity, reduction, bx, by);
}

std::optional<std::vector<std::byte>> read_all(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  struct stat state {};
  std::optional<std::vector<std::byte>> bytes;
  if (::fstat(file, &state) == 0 && S_ISREG(state.st_mode) && state.st_size < (off_t{64} << 20)) {
    bytes.emplace(static_cast<size_t>(state.st_size));
    size_t at = 0;
    while (at < bytes->size()) {
      const ssize_t got = ::read(file, bytes->data() + at, bytes->size() - at);
      if (got <= 0) break;
      at += static_cast<size_t>(got);
    }
    bytes->resize(at);
    ::futimens(file, nullptr);  // used now; a folder that cannot be written keeps its times
  }
  ::close(file);
  return bytes;
}

/// Empty, or why not.
std::string write_all(const fs::path& path, const std::vector<std::byte>& bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file < 0) return std::strerror(errno);
  size_t at = 0;
  int error = 0;
  while (at < bytes.size() && error == 0) {
    const ssize_t put = ::write(file, bytes.data() + at, bytes.size() - at);
    if (put > 0)
      at += static_cast<size_t>(put);
    else if (put == 0 || errno != EINTR)
      error = put == 0 ? ENOSPC : errno;
  }
  if (::close(file) != 0 && error == 0) error = errno;
  return error == 0 ? "" : std::strerror(error);
}

}  // namespace

BlockStore::BlockStore(fs::path folder, uint64_t budget_bytes)
    : folder_(std::move(folder)), budget_bytes_(budget_bytes) {}

BlockStore::~BlockStore() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (writer_.joinable()) writer_.join();
}

std::shared_ptr<BlockStore> BlockStore::of_user(uint64_t budget_bytes) {
  if (budget_bytes == 0) return nullptr;
  const fs::path cache = cache_dir();
  if (cache.empty()) {
    log_warning("no folder for caches could be made (set NEPHO_CACHE); blocks of rasters are not kept on disk");
    return nullptr;
  }
  static std::mutex mutex;
  static std::map<std::pair<std::string, uint64_t>, std::weak_ptr<BlockStore>> open;
  const std::lock_guard lock(mutex);
  std::weak_ptr<BlockStore>& known = open[{cache.string(), budget_bytes}];
  std::shared_ptr<BlockStore> store = known.lock();
  if (!store) known = store = std::make_shared<BlockStore>(cache / "blocks", budget_bytes);
  return store;
}

BlockStore::Source BlockStore::source_of(const RasterInfo& info) {
  Source source;
  if (info.fingerprint.empty()) return source;
  source.identity = fmt::format("nepho " NEPHO_VERSION " blocks 1 {} {}x{}x{} {} {} {} {}\n{}", info.path, info.width,
                                info.height, info.bands, info.bounds.west_deg, info.bounds.south_deg,
                                info.bounds.east_deg, info.bounds.north_deg, info.fingerprint);
  source.folder = fmt::format("{:016x}", hash_of(source.identity, 0xcbf29ce484222325ull));
  source.bands = info.bands;
  return source;
}

fs::path BlockStore::path_of(const Source& source, uint32_t reduction, uint32_t bx, uint32_t by) const {
  return folder_ / source.folder / fmt::format("{}_{}_{}{}", reduction, by, bx, kSuffix);
}

std::optional<RasterBlock> BlockStore::load(const Source& source, uint32_t reduction, uint32_t bx, uint32_t by) {
  if (!source) return std::nullopt;
  const fs::path path = path_of(source, reduction, bx, by);
  const std::optional<std::vector<std::byte>> bytes = read_all(path);
  if (!bytes) return std::nullopt;
  std::optional<RasterBlock> block = decode_block(*bytes, source.bands, key_of(source, reduction, bx, by));
  if (block) {
    ++loaded_;
  } else {
    ++damaged_;
    std::error_code ignored;
    fs::remove(path, ignored);
  }
  return block;
}

void BlockStore::save(const Source& source, uint32_t reduction, uint32_t bx, uint32_t by,
                      std::shared_ptr<const RasterBlock> block) {
  if (!source || !writing_) return;
  const uint64_t bytes = block->values.size() * sizeof(float) + block->valid.size();
  Job job{source, reduction, bx, by, std::move(block)};
  {
    const std::lock_guard lock(mutex_);
    if (waiting_bytes_ + bytes <= kMostWaitingBytes) {
      waiting_bytes_ += bytes;
      jobs_.push_back(std::move(job));
      if (!writer_.joinable()) writer_ = std::thread([this] { serve(); });
      changed_.notify_all();
      return;
    }
  }
  write(job);  // the writer cannot keep up: the caller helps
}

void BlockStore::flush() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty() && !busy_; });
}

void BlockStore::serve() {
  give_way();  // nobody waits for it
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return !jobs_.empty() || stop_; });
    if (jobs_.empty()) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    busy_ = true;
    lock.unlock();
    if (writing_) write(job);
    lock.lock();
    busy_ = false;
    waiting_bytes_ -= job.block->values.size() * sizeof(float) + job.block->valid.size();
    if (jobs_.empty()) changed_.notify_all();
  }
}

void BlockStore::write(const Job& job) {
  const fs::path path = path_of(job.source, job.reduction, job.bx, job.by);
  std::error_code ec;
  fs::create_directories(path.parent_path(), ec);
  if (ec) {
    turn_off(ec.message());
    return;
  }
  const std::vector<std::byte> bytes =
      encode_block(*job.block, job.source.bands, key_of(job.source, job.reduction, job.bx, job.by));
  const fs::path temporary = path.parent_path() / fmt::format(".{}.{}.tmp", ::getpid(), ++serial_);
  std::string why = write_all(temporary, bytes);
  if (why.empty()) {
    fs::rename(temporary, path, ec);
    if (ec) why = ec.message();
  }
  if (!why.empty()) {
    fs::remove(temporary, ec);
    turn_off(why);
    return;
  }
  ++saved_;
  const std::lock_guard lock(room_mutex_);
  bytes_ += bytes.size();
  if (!counted_ || bytes_ > budget_bytes_) make_room();
}

/// Counts what all processes have written, and removes the oldest files where that is too much.
void BlockStore::make_room() {
  struct File {
    fs::path path;
    fs::file_time_type used;
    uint64_t bytes;
  };
  std::vector<File> files;
  std::error_code ec, ignored;
  const auto now = fs::file_time_type::clock::now();
  bytes_ = 0;
  for (fs::recursive_directory_iterator it(folder_, fs::directory_options::skip_permission_denied, ec), end;
       !ec && it != end; it.increment(ec)) {
    const fs::path& path = it->path();
    if (!it->is_regular_file(ignored)) continue;
    const auto used = fs::last_write_time(path, ignored);
    if (ignored) continue;  // another process removed it
    const uint64_t bytes = it->file_size(ignored);
    if (ignored) continue;
    if (path.extension() == ".tmp" && now - used > kStale)
      fs::remove(path, ignored);
    else if (path.extension() == kSuffix)
      files.push_back({path, used, bytes});
    bytes_ += bytes;
  }
  counted_ = true;
  if (bytes_ <= budget_bytes_) return;
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
  for (const File& file : files) {
    if (bytes_ <= budget_bytes_ / 8 * 7) break;
    if (fs::remove(file.path, ignored)) ++removed_;
    bytes_ -= std::min(bytes_, file.bytes);
    fs::remove(file.path.parent_path(), ignored);  // once it is empty
  }
}

void BlockStore::turn_off(const std::string& why) {
  if (!writing_.exchange(false)) return;
  log_warning("{}: cannot be written ({}); blocks of rasters are not kept on disk", folder_.string(), why);
}

BlockStore::Stats BlockStore::stats() const {
  return {.loaded = loaded_, .saved = saved_, .damaged = damaged_, .removed = removed_, .writing = writing_};
}

}  // namespace nepho
