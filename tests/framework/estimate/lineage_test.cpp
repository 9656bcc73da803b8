// Lineage against dense matrices: combination, cross-covariance, noise and folding.
#include "framework/estimate/lineage.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <map>
#include <set>

#include "framework/estimate/budget.h"
#include "framework/estimate/random.h"

namespace ilss {
namespace {

using Eigen::MatrixXd;

MatrixXd random_matrix(std::size_t rows, std::size_t columns, RandomBits& bits) {
  return MatrixXd::NullaryExpr(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns),
                               [&] { return draw_normal(bits); });
}

std::size_t random_count(std::size_t least, std::size_t most, RandomBits& bits) {
  return least + draw_index(bits, most - least + 1);
}

/// About `count` columns over sources of three owners, drawn from a pool so that lineages share.
Lineage random_lineage(std::size_t dimension, std::size_t count, std::uint32_t pool,
                       RandomBits& bits) {
  Lineage lineage(dimension);
  for (std::size_t k = 0; k < count; ++k) {
    const MatrixXd column = random_matrix(dimension, 1, bits);
    const auto which = static_cast<std::uint32_t>(random_count(0, pool - 1, bits));
    const std::uint32_t owner = which % 3;
    lineage.add({owner, which / 3, owner == 2 ? persistent_tick : 7}, {column.data(), dimension});
  }
  return lineage;
}

using DenseColumns = std::map<Source, Eigen::VectorXd>;

DenseColumns dense(const Lineage& lineage) {
  DenseColumns columns;
  for (std::size_t k = 0; k < lineage.size(); ++k)
    columns[lineage.sources()[k]] = lineage.factor().col(static_cast<Eigen::Index>(k));
  return columns;
}

double relative_difference(const MatrixXd& a, const MatrixXd& b) {
  return (a - b).norm() / std::max(1e-300, b.norm());
}

bool sorted_without_repeats(const Lineage& lineage) {
  for (std::size_t k = 1; k < lineage.size(); ++k)
    if (!(lineage.sources()[k - 1] < lineage.sources()[k])) return false;
  return true;
}

bool everything(const Source&) { return true; }
bool only_random(const Source& s) { return !s.persistent(); }

TEST(Compose, EqualsDenseMatrixProductForAnySharingOfSources) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    const std::size_t rows = random_count(1, 8, bits);
    const std::size_t terms =
        seed % 40 == 0 ? random_count(65, 80, bits) : random_count(1, 5, bits);
    // A small pool makes most sources shared, a large one nearly none.
    const std::uint32_t pool = seed % 3 == 0 ? 6 : seed % 3 == 1 ? 60 : 100'000;
    std::vector<Lineage> lineages;
    std::vector<MatrixXd> jacobians;
    for (std::size_t t = 0; t < terms; ++t) {
      const std::size_t dimension = random_count(1, 8, bits);
      lineages.push_back(random_lineage(dimension, random_count(0, 12, bits), pool, bits));
      jacobians.push_back(random_matrix(rows, dimension, bits));
    }
    DenseColumns expected;
    std::vector<LineageTerm> list;
    for (std::size_t t = 0; t < terms; ++t) {
      list.push_back({jacobians[t].data(), &lineages[t]});
      for (const auto& [source, column] : dense(lineages[t])) {
        auto& sum =
            expected.try_emplace(source, Eigen::VectorXd::Zero(jacobians[t].rows())).first->second;
        sum += jacobians[t] * column;
      }
    }
    Lineage out(3);
    out.add({9, 9, 9}, 0, 1.0);  // must be forgotten
    compose(list, rows, out);
    ASSERT_EQ(out.dimension(), rows);
    ASSERT_TRUE(sorted_without_repeats(out));
    ASSERT_EQ(out.size(), expected.size());
    for (const auto& [source, column] : dense(out)) {
      ASSERT_TRUE(expected.contains(source));
      ASSERT_LT((column - expected[source]).norm(), 1e-13 * (1 + expected[source].norm()));
    }
  }
}

TEST(Compose, OfNothingIsExact) {
  Lineage out(2);
  out.add({1, 0, 0}, 0, 1.0);
  compose({}, 4, out);
  EXPECT_EQ(out.dimension(), 4u);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(out.covariance(), MatrixXd::Zero(4, 4));
}

TEST(Compose, SubtractingALineageFromItselfLeavesExactlyNoVariance) {
  RandomBits bits(5);
  const Lineage x = random_lineage(4, 20, 1000, bits);
  const MatrixXd plus = MatrixXd::Identity(4, 4);
  const MatrixXd minus = -plus;
  const LineageTerm terms[] = {{plus.data(), &x}, {minus.data(), &x}};
  Lineage out;
  compose(terms, 4, out);
  EXPECT_EQ(out.covariance(), MatrixXd::Zero(4, 4));
}

TEST(Covariance, IsNeverIndefinite) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    // Fewer sources than components: singular, where rounding would show.
    const Lineage x = random_lineage(8, random_count(1, 12, bits), 1000, bits);
    const MatrixXd covariance = x.covariance();
    EXPECT_EQ(covariance, covariance.transpose());
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-14 * eigen.eigenvalues().maxCoeff());
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_NEAR(x.variance(i), covariance.diagonal()[static_cast<Eigen::Index>(i)],
                  1e-13 * x.variance(i));
  }
}

TEST(CrossCovariance, CountsCommonSourcesOnly) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    const Lineage a = random_lineage(random_count(1, 6, bits), 15, 40, bits);
    const Lineage b = random_lineage(random_count(1, 6, bits), 15, 40, bits);
    MatrixXd expected = MatrixXd::Zero(static_cast<Eigen::Index>(a.dimension()),
                                       static_cast<Eigen::Index>(b.dimension()));
    const DenseColumns of_b = dense(b);
    for (const auto& [source, column] : dense(a))
      if (const auto other = of_b.find(source); other != of_b.end())
        expected += column * other->second.transpose();
    EXPECT_LT((cross_covariance(a, b) - expected).norm(), 1e-12);
    EXPECT_LT((cross_covariance(b, a) - expected.transpose()).norm(), 1e-12);
  }
}

TEST(CrossCovariance, WithItselfIsTheCovariance) {
  RandomBits bits(11);
  const Lineage a = random_lineage(5, 30, 1000, bits);
  EXPECT_LT(relative_difference(cross_covariance(a, a), a.covariance()), 1e-14);
}

TEST(Add, JoinsColumnsOfOneSource) {
  Lineage x(2);
  x.add({1, 0, 0}, std::vector{1.0, 2.0});
  x.add({0, 0, 0}, std::vector{5.0, 6.0});
  x.add({1, 0, 0}, std::vector{3.0, -2.0});
  x.add({1, 0, 0}, 1, 7.0);
  x.add({0, 1, 0}, 1, 9.0);
  ASSERT_EQ(x.size(), 3u);
  EXPECT_EQ(x.factor(), (MatrixXd(2, 3) << 5, 0, 4, 6, 9, 7).finished());
  EXPECT_TRUE(sorted_without_repeats(x));
}

TEST(AddNoise, OfIndependentComponentsGivesEachItsOwnColumn) {
  Lineage x(3);
  x.add_noise({4, 10, 2}, Eigen::Vector3d(4, 9, 25).asDiagonal().toDenseMatrix());
  ASSERT_EQ(x.size(), 3u);
  EXPECT_EQ(x.sources()[1], (Source{4, 11, 2}));
  EXPECT_EQ(x.factor(), Eigen::Vector3d(2, 3, 5).asDiagonal().toDenseMatrix());
}

TEST(AddNoise, OfZeroCovarianceAddsNothing) {
  Lineage x(3);
  x.add_noise({0, 0, 0}, MatrixXd::Zero(3, 3));
  EXPECT_TRUE(x.empty());
}

TEST(AddNoise, ReproducesCovariancesOfEveryRank) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    const std::size_t m = seed % 50 == 0 ? 20 : random_count(1, 8, bits);
    const MatrixXd root = random_matrix(m, random_count(0, m, bits), bits);
    MatrixXd covariance = root * root.transpose();
    if (root.cols() == 0) covariance = MatrixXd::Zero(root.rows(), root.rows());
    Lineage x(m);
    x.add_noise({0, 0, 0}, covariance);
    EXPECT_LE(x.size(), m);
    EXPECT_LT((x.covariance() - covariance).norm(), 1e-13 * (1 + covariance.norm()));
  }
}

TEST(Fold, KeepsCovarianceBudgetAndCrossCovarianceWithWhatIsNotFolded) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    Lineage x = random_lineage(random_count(1, 8, bits), random_count(0, 60, bits), 150, bits);
    const Lineage other = random_lineage(3, 40, 150, bits);
    Lineage other_persistent(3);
    for (std::size_t k = 0; k < other.size(); ++k)
      if (other.sources()[k].persistent())
        other_persistent.add(other.sources()[k], other.column(k));
    const Lineage before = x;
    x.fold(only_random, 3);
    EXPECT_TRUE(sorted_without_repeats(x));
    EXPECT_LT((x.covariance() - before.covariance()).norm(),
              1e-12 * (1 + before.covariance().norm()));
    EXPECT_LT(
        (cross_covariance(x, other_persistent) - cross_covariance(before, other_persistent)).norm(),
        1e-12);
    const auto old_budget = budget(before);
    const auto new_budget = budget(x);
    ASSERT_EQ(new_budget.size(), old_budget.size());
    for (std::size_t e = 0; e < old_budget.size(); ++e) {
      EXPECT_EQ(new_budget[e].owner, old_budget[e].owner);
      EXPECT_EQ(new_budget[e].persistent, old_budget[e].persistent);
      for (std::size_t i = 0; i < x.dimension(); ++i)
        EXPECT_NEAR(new_budget[e].variance[i], old_budget[e].variance[i],
                    1e-12 * (1 + old_budget[e].variance[i]));
    }
    std::map<std::uint32_t, std::size_t> random_columns;
    for (const Source& s : x.sources()) random_columns[s.owner] += s.persistent() ? 0 : 1;
    for (const auto& [owner, count] : random_columns) EXPECT_LE(count, x.dimension()) << owner;
  }
}

TEST(Fold, ChangesNothingTheSecondTime) {
  RandomBits bits(21);
  Lineage x = random_lineage(4, 60, 1000, bits);
  x.fold(everything, 1);
  const Lineage once = x;
  x.fold(everything, 1);
  EXPECT_TRUE(std::equal(x.sources().begin(), x.sources().end(), once.sources().begin(),
                         once.sources().end()));
  EXPECT_EQ(x.factor(), once.factor());
}

TEST(Fold, LeavesFewColumnsAsTheyAre) {
  Lineage x(3);
  for (std::uint32_t k = 0; k < 3; ++k) x.add({0, k, 4}, k, 1.0);
  x.fold(everything, 1);
  EXPECT_EQ(x.sources()[2], (Source{0, 2, 4}));
}

TEST(Fold, AtTwoPlacesGivesDifferentSources) {
  RandomBits bits(22);
  Lineage a = random_lineage(2, 60, 1000, bits);
  Lineage b = random_lineage(2, 60, 1000, bits);
  a.fold(everything, 1);
  b.fold(everything, 2);
  EXPECT_EQ(cross_covariance(a, b), MatrixXd::Zero(2, 2));
}

TEST(Fold, NamesItsColumnsAfterTheLatestTickSoThatAMemorysTicksDiffer) {
  // A filter: yesterday's folded block and today's new columns, folded again at the same place.
  Lineage yesterday(1);
  for (std::uint32_t k = 0; k < 3; ++k) yesterday.add({0, k, 1}, 0, 1.0 + k);
  yesterday.fold(everything, 1);
  Lineage today = yesterday;
  today.add({0, 0, 2}, 0, 5.0);
  today.fold(everything, 1);
  ASSERT_EQ(yesterday.size(), 1u);
  ASSERT_EQ(today.size(), 1u);
  EXPECT_EQ(today.sources()[0].tick, 2);
  EXPECT_NE(today.sources()[0], yesterday.sources()[0]);
}

TEST(Fold, KeepsPersistentErrorsPersistent) {
  Lineage x(1);
  for (std::uint32_t k = 0; k < 4; ++k) {
    x.add({0, k, persistent_tick}, 0, 1.0);
    x.add({0, k, 5}, 0, 2.0);
  }
  x.fold(everything, 1);
  ASSERT_EQ(x.size(), 2u);
  EXPECT_TRUE(x.sources()[0].persistent());
  EXPECT_DOUBLE_EQ(x.column(0)[0], 2.0);
  EXPECT_EQ(x.sources()[1].tick, 5);
  EXPECT_DOUBLE_EQ(x.column(1)[0], 4.0);
}

TEST(Fold, OfSlightlyDifferentColumnsGivesSlightlyDifferentColumns) {
  // Otherwise persistent columns folded at two ticks could cancel in a mean.
  RandomBits bits(23);
  const MatrixXd g = random_matrix(3, 9, bits);
  const MatrixXd change = 1e-6 * random_matrix(3, 9, bits);
  Lineage a(3);
  Lineage b(3);
  for (std::uint32_t k = 0; k < 9; ++k) {
    const Eigen::VectorXd nearby = g.col(k) + change.col(k);
    a.add({0, k, persistent_tick}, {g.col(k).data(), 3});
    b.add({0, k, persistent_tick}, {nearby.data(), 3});
  }
  a.fold(everything, 1);
  b.fold(everything, 1);
  EXPECT_LT((a.factor() - b.factor()).norm(), 1e-4);
}

TEST(FoldTogether, LeavesMColumnsOfOneOwnerWithTheSameCovariance) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    Lineage x = random_lineage(random_count(1, 8, bits), 60, 1000, bits);
    const Lineage before = x;
    x.fold_together(only_random, 5, 77);
    EXPECT_LT(relative_difference(x.covariance(), before.covariance()), 1e-13);
    EXPECT_TRUE(sorted_without_repeats(x));
    std::size_t folded = 0;
    for (const Source& s : x.sources()) {
      EXPECT_TRUE(s.persistent() || s.owner == 77);
      folded += s.owner == 77 ? 1 : 0;
    }
    EXPECT_EQ(folded, x.dimension());
  }
}

TEST(FoldTogether, OfPersistentErrorsAlonePersists) {
  Lineage x(1);
  for (std::uint32_t k = 0; k < 3; ++k) x.add({k, 0, persistent_tick}, 0, 1.0);
  x.fold_together(everything, 1, 9);
  ASSERT_EQ(x.size(), 1u);
  EXPECT_EQ(x.sources()[0].owner, 9u);
  EXPECT_TRUE(x.sources()[0].persistent());
}

TEST(Budget, AddsUpToTheVariance) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    const Lineage x = random_lineage(6, 40, 1000, bits);
    for (std::size_t i = 0; i < 6; ++i) {
      double sum = 0;
      std::set<std::uint32_t> owners;
      for (const BudgetEntry& entry : budget(x)) {
        sum += entry.variance[i];
        EXPECT_TRUE(owners.insert(entry.owner).second);
      }
      EXPECT_NEAR(sum, x.variance(i), 1e-12 * x.variance(i));
    }
  }
}

TEST(Budget, OfAnExactEstimateIsEmpty) { EXPECT_TRUE(budget(Lineage(3)).empty()); }

}  // namespace
}  // namespace ilss
