// Counts every allocation of a test program, Eigen's and those of the libraries included, by
// standing in for malloc. Include in one source file of a program only.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// The sanitizers stand in for malloc themselves.
constexpr bool counts_allocations = false;
constexpr std::size_t allocation_count = 0;
#else
constexpr bool counts_allocations = true;
static std::atomic<std::size_t> allocation_count = 0;
extern "C" void* __libc_malloc(std::size_t size);  // NOLINT(bugprone-reserved-identifier)
extern "C" void* malloc(std::size_t size) noexcept {
  ++allocation_count;
  return __libc_malloc(size);
}
#endif

/// Skips a test that cannot count.
#define SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED() \
  if (!counts_allocations) GTEST_SKIP() << "by design: a sanitizer stands in for malloc"
