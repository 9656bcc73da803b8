// The elements of a set.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "framework/estimate/estimate.h"

namespace ilss {

/// A list of estimates that keeps the buffers of those that it no longer holds, so that sets whose
/// size changes from tick to tick do not allocate. An element that comes back is blank: without
/// values, labels, sources and the `correlation_unknown` of what it was.
class Elements {
 public:
  Elements() = default;
  Elements(std::initializer_list<Estimate> elements) : kept_(elements), size_(elements.size()) {}
  Elements(const Elements& other) { *this = other; }
  Elements(Elements&& other) noexcept
      : kept_(std::move(other.kept_)), size_(std::exchange(other.size_, 0)) {}
  Elements& operator=(const Elements& other) {
    if (this == &other) return *this;
    resize(other.size_);
    std::copy(other.begin(), other.end(), begin());
    return *this;
  }
  Elements& operator=(Elements&& other) noexcept {
    kept_.swap(other.kept_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~Elements() = default;

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  Estimate* begin() { return kept_.data(); }
  Estimate* end() { return kept_.data() + size_; }
  const Estimate* begin() const { return kept_.data(); }
  const Estimate* end() const { return kept_.data() + size_; }
  Estimate& operator[](std::size_t i) { return kept_[i]; }
  const Estimate& operator[](std::size_t i) const { return kept_[i]; }
  Estimate& front() { return kept_.front(); }
  const Estimate& front() const { return kept_.front(); }
  Estimate& back() { return kept_[size_ - 1]; }
  const Estimate& back() const { return kept_[size_ - 1]; }

  void clear() { size_ = 0; }
  void resize(std::size_t size) {
    if (size > kept_.size()) kept_.resize(size);
    for (; size_ < size; ++size_) blank(kept_[size_]);
    size_ = size;
  }
  Estimate& emplace_back() {
    resize(size_ + 1);
    return back();
  }
  void push_back(Estimate element) { emplace_back() = std::move(element); }

 private:
  static void blank(Estimate& element) {
    element.type = nullptr;
    element.frame.clear();
    element.value.clear();
    element.labels.clear();
    element.lineage.reset(0);
    element.correlation_unknown = false;
  }

  std::vector<Estimate> kept_;
  std::size_t size_ = 0;
};

}  // namespace ilss
