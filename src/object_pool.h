// Objects that threads lend each other, because they are costly to make.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace psplit {

// One object for each thread that works at a time. Thread-safe; the objects are not.
template <typename Object>
class ObjectPool {
 public:
  class Lease {
   public:
    explicit Lease(ObjectPool& pool) : Lease(pool, [] { return std::make_unique<Object>(); }) {}
    // `make()` returns a std::unique_ptr<Object>. It is called if all objects are lent.
    template <typename Make>
    Lease(ObjectPool& pool, Make make) : pool_(pool), object_(pool.take()) {
      if (object_ == nullptr) object_ = make();
    }
    ~Lease() { pool_.put(std::move(object_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Object& operator*() const { return *object_; }
    Object* operator->() const { return object_.get(); }

   private:
    ObjectPool& pool_;
    std::unique_ptr<Object> object_;
  };

  // Frees the objects that no thread uses.
  void clear() {
    const std::lock_guard lock(mutex_);
    idle_.clear();
  }

 private:
  std::unique_ptr<Object> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return nullptr;
    std::unique_ptr<Object> object = std::move(idle_.back());
    idle_.pop_back();
    return object;
  }
  void put(std::unique_ptr<Object> object) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(object));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Object>> idle_;
};

}  // namespace psplit
