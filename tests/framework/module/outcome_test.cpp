// The three outcomes of a tick.
#include "framework/module/outcome.h"

#include <gtest/gtest.h>

#include <set>

namespace ilss {
namespace {

TEST(Outcome, IsExactlyOneOfThree) {
  const Outcome<int> value = 3;
  EXPECT_TRUE(value && value.has_output() && !value.is_fault() && !value.is_pending());
  EXPECT_EQ(*value, 3);
  const Outcome<int> fault = Fault{FaultKind::stale, "too old"};
  EXPECT_TRUE(!fault && !fault.has_output() && fault.is_fault() && !fault.is_pending());
  EXPECT_EQ(fault.fault().message, "too old");
  const Outcome<int> pending = Pending{};
  EXPECT_TRUE(!pending && !pending.has_output() && !pending.is_fault() && pending.is_pending());
}

TEST(Outcome, WithoutValueIsExactlyOneOfThree) {
  const Outcome<> value;
  EXPECT_TRUE(value && value.has_output() && !value.is_fault() && !value.is_pending());
  const Outcome<> fault = Fault{FaultKind::degenerate, "parallel"};
  EXPECT_TRUE(!fault && !fault.has_output() && fault.is_fault() && !fault.is_pending());
  EXPECT_EQ(fault.fault().kind, FaultKind::degenerate);
  const Outcome<> pending = Pending{};
  EXPECT_TRUE(!pending && !pending.has_output() && !pending.is_fault() && pending.is_pending());
}

TEST(FaultName, IsDifferentForEveryKind) {
  std::set<std::string_view> names;
  for (int kind = 0; kind <= static_cast<int>(FaultKind::internal); ++kind)
    names.insert(fault_name(static_cast<FaultKind>(kind)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(FaultKind::internal) + 1);
  EXPECT_EQ(fault_name(FaultKind::no_detection), "no_detection");
}

}  // namespace
}  // namespace ilss
