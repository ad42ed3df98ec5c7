#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace nepho {

/// How much memory the caches of a scene may hold together, and which of their values go when it is full: those that
/// were asked for longest ago, whichever cache they are in. Thread-safe.
class HostBudget {
 public:
  explicit HostBudget(uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}
  HostBudget(const HostBudget&) = delete;
  HostBudget& operator=(const HostBudget&) = delete;

  uint64_t limit_bytes() const { return limit_bytes_; }
  uint64_t bytes() const { return bytes_; }            ///< held now
  uint64_t peak_bytes() const { return peak_bytes_; }  ///< the most that was ever held at once
  uint64_t dropped() const { return dropped_; }        ///< values that had to go, since the start

  /// What a cache tells its budget, and the other way round. Used by HostCache.
  class Member {
   public:
    struct Use {
      uint64_t stamp, bytes;
    };
    virtual ~Member() = default;
    virtual void list(std::vector<Use>& uses) const = 0;
    /// Drops what was last used at `stamp` or before; returns its bytes and count.
    virtual std::pair<uint64_t, uint64_t> drop_until(uint64_t stamp) = 0;
  };
  void join(Member& member);
  /// Drops all of its values first.
  void leave(Member& member);
  /// The time of a use: grows with every call.
  uint64_t stamp() { return clock_.fetch_add(1, std::memory_order_relaxed) + 1; }
  /// Counts bytes of a value that is about to be held; the oldest values make room for it first.
  void add(uint64_t bytes);

 private:
  void make_room(uint64_t bytes);
  const uint64_t limit_bytes_;
  std::atomic<uint64_t> bytes_{0}, peak_bytes_{0}, dropped_{0}, clock_{0};
  std::mutex members_mutex_;
  std::vector<Member*> members_;
};

/// Values by key, kept as long as the budget allows. A value in use outlives its place here by its shared_ptr.
/// Thread-safe; a value is made once even when several threads ask for it together.
template <typename Key, typename Value, typename Hash = std::hash<Key>>
class HostCache final : private HostBudget::Member {
 public:
  struct Made {
    std::shared_ptr<const Value> value;
    uint64_t bytes = 0;
  };
  explicit HostCache(std::shared_ptr<HostBudget> budget) : budget_(std::move(budget)) { budget_->join(*this); }
  ~HostCache() override { budget_->leave(*this); }
  HostCache(const HostCache&) = delete;
  HostCache& operator=(const HostCache&) = delete;

  /// The value of a key. Without one `make()`, which returns Made, is called: outside of all locks, so it may ask this
  /// cache for other keys. What it throws goes to the caller, and the next one tries again.
  template <typename F>
  std::shared_ptr<const Value> get(const Key& key, F&& make) const {
    Shard& shard = shard_of(key);
    std::shared_ptr<Entry> entry;
    {
      const std::lock_guard lock(shard.mutex);
      std::shared_ptr<Entry>& slot = shard.entries[key];
      if (!slot) slot = std::make_shared<Entry>();
      slot->stamp = budget_->stamp();
      entry = slot;
    }
    std::call_once(entry->once, [&] {
      Made made = make();
      const uint64_t bytes = made.bytes + kOverheadBytes;
      budget_->add(bytes);
      const std::lock_guard lock(shard.mutex);
      entry->value = std::move(made.value);
      entry->bytes = bytes;
    });
    return entry->value;
  }
  /// The value of a key if it is there; null else. Counts as a use.
  std::shared_ptr<const Value> find(const Key& key) const {
    Shard& shard = shard_of(key);
    const std::lock_guard lock(shard.mutex);
    const auto found = shard.entries.find(key);
    if (found == shard.entries.end() || found->second->bytes == 0) return nullptr;
    found->second->stamp = budget_->stamp();
    return found->second->value;
  }
  size_t size() const {
    size_t n = 0;
    for (const Shard& shard : shards_) {
      const std::lock_guard lock(shard.mutex);
      n += shard.entries.size();
    }
    return n;
  }

 private:
  static constexpr uint64_t kOverheadBytes = 160;  // of the entry and its place in the map
  struct Entry {
    std::once_flag once;
    std::shared_ptr<const Value> value;
    uint64_t stamp = 0;
    uint64_t bytes = 0;  // 0: not made yet
  };
  /// Threads that ask for different keys rarely meet.
  struct Shard {
    mutable std::mutex mutex;
    std::unordered_map<Key, std::shared_ptr<Entry>, Hash> entries;
  };
  Shard& shard_of(const Key& key) const {
    return shards_[(static_cast<uint64_t>(Hash{}(key)) * 0x9e3779b97f4a7c15ull) >> 61];
  }
  void list(std::vector<Use>& uses) const override {
    for (const Shard& shard : shards_) {
      const std::lock_guard lock(shard.mutex);
      for (const auto& [key, entry] : shard.entries)
        if (entry->bytes > 0) uses.push_back({entry->stamp, entry->bytes});
    }
  }
  std::pair<uint64_t, uint64_t> drop_until(uint64_t stamp) override {
    std::pair<uint64_t, uint64_t> dropped{0, 0};
    std::vector<std::shared_ptr<Entry>> gone;  // freed after the locks
    for (Shard& shard : shards_) {
      const std::lock_guard lock(shard.mutex);
      for (auto it = shard.entries.begin(); it != shard.entries.end();) {
        if (it->second->bytes == 0 || it->second->stamp > stamp) {
          ++it;
          continue;
        }
        dropped.first += it->second->bytes;
        ++dropped.second;
        gone.push_back(std::move(it->second));
        it = shard.entries.erase(it);
      }
    }
    return dropped;
  }

  std::shared_ptr<HostBudget> budget_;
  mutable std::array<Shard, 8> shards_;
};

}  // namespace nepho
