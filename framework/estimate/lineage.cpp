#include "framework/estimate/lineage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "framework/estimate/decompositions.h"

namespace ilss {
namespace {

// Marks columns made by folding; their low bits are folder * most_folded + index.
constexpr std::uint32_t folded_column = 0x80000000u;
constexpr std::uint32_t most_folded = 64;

/// out (Rows x K) = or += J (Rows x columns) * in (columns x K), all column-major. `Columns` is the
/// number of columns where that is known to the compiler, which saves a third of the time, else 0.
template <std::size_t Rows, std::size_t Columns, bool accumulate>
void multiply_fixed(const double* jacobian, const double* in, std::size_t columns,
                    std::size_t k_count, double* out) {
  const std::size_t n = Columns > 0 ? Columns : columns;
  for (std::size_t k = 0; k < k_count; ++k, in += n, out += Rows) {
    std::array<double, Rows> sum{};
    if constexpr (accumulate)
      for (std::size_t i = 0; i < Rows; ++i) sum[i] = out[i];
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = 0; i < Rows; ++i) sum[i] += jacobian[j * Rows + i] * in[j];
    for (std::size_t i = 0; i < Rows; ++i) out[i] = sum[i];
  }
}

template <std::size_t Rows, bool accumulate>
void multiply_rows(const double* jacobian, const double* in, std::size_t columns,
                   std::size_t k_count, double* out) {
  switch (columns) {
    case 1:
      return multiply_fixed<Rows, 1, accumulate>(jacobian, in, columns, k_count, out);
    case 2:
      return multiply_fixed<Rows, 2, accumulate>(jacobian, in, columns, k_count, out);
    case 3:
      return multiply_fixed<Rows, 3, accumulate>(jacobian, in, columns, k_count, out);
    case 4:
      return multiply_fixed<Rows, 4, accumulate>(jacobian, in, columns, k_count, out);
    default:
      return multiply_fixed<Rows, 0, accumulate>(jacobian, in, columns, k_count, out);
  }
}

/// As above for any number of rows.
template <bool accumulate>
void multiply(const double* jacobian, const double* in, std::size_t rows, std::size_t columns,
              std::size_t k_count, double* out) {
  switch (rows) {
    case 1:
      return multiply_rows<1, accumulate>(jacobian, in, columns, k_count, out);
    case 2:
      return multiply_rows<2, accumulate>(jacobian, in, columns, k_count, out);
    case 3:
      return multiply_rows<3, accumulate>(jacobian, in, columns, k_count, out);
    case 4:
      return multiply_rows<4, accumulate>(jacobian, in, columns, k_count, out);
    case 6:
      return multiply_rows<6, accumulate>(jacobian, in, columns, k_count, out);
    default:
      break;
  }
  for (std::size_t k = 0; k < k_count; ++k, in += columns, out += rows) {
    if constexpr (!accumulate) std::fill_n(out, rows, 0.0);
    for (std::size_t j = 0; j < columns; ++j)
      for (std::size_t i = 0; i < rows; ++i) out[i] += jacobian[j * rows + i] * in[j];
  }
}

/// out = G Gᵀ of a factor of `Rows` rows, column-major.
template <std::size_t Rows>
void square_fixed(const double* factor, std::size_t columns, Eigen::Ref<Eigen::MatrixXd> out) {
  std::array<double, Rows * Rows> sum{};
  for (std::size_t k = 0; k < columns; ++k, factor += Rows)
    for (std::size_t j = 0; j < Rows; ++j)
      for (std::size_t i = 0; i < Rows; ++i) sum[j * Rows + i] += factor[i] * factor[j];
  double* column = out.data();
  for (std::size_t j = 0; j < Rows; ++j, column += out.outerStride())
    std::copy_n(sum.data() + j * Rows, Rows, column);
}

/// F with F Fᵀ = covariance: by Cholesky, and where that is singular the symmetric square root,
/// which rounding cannot make indefinite.
template <typename Matrix>
Matrix noise_factor(const Matrix& covariance) {
  const auto factors = cholesky(covariance);
  if (factors.info() == Eigen::Success) return Matrix(factors.matrixL());
  const auto eigen = symmetric_eigen(covariance);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// A lower triangle L with L Lᵀ = the sum of g gᵀ over the columns g added: LQ of [L g] by Givens
/// rotations, on the stack. Its diagonal is never negative, so L changes continuously with the
/// columns.
class TriangularFactor {
 public:
  static constexpr std::size_t most_rows = most_folded;

  explicit TriangularFactor(std::size_t rows) : rows_(rows) {
    std::fill_n(lower_.begin(), rows * rows, 0.0);
  }
  std::span<const double> column(std::size_t k) const { return {lower_.data() + k * rows_, rows_}; }
  void add(std::span<const double> column) {
    std::array<double, most_rows> g;
    std::copy_n(column.begin(), rows_, g.begin());
    for (std::size_t k = 0; k < rows_; ++k) {
      if (g[k] == 0) continue;
      double* l = lower_.data() + k * rows_;
      const double r = std::hypot(l[k], g[k]);
      const double cosine = l[k] / r;
      const double sine = g[k] / r;
      for (std::size_t i = k; i < rows_; ++i) {
        const double old = l[i];
        l[i] = cosine * old + sine * g[i];
        g[i] = cosine * g[i] - sine * old;
      }
    }
  }

 private:
  std::size_t rows_;
  std::array<double, most_rows * most_rows> lower_;
};

}  // namespace

void Lineage::add(Source source, std::span<const double> column) {
  const auto place = std::lower_bound(sources_.begin(), sources_.end(), source);
  const auto k = place - sources_.begin();
  const auto begin = factor_.begin() + k * static_cast<std::ptrdiff_t>(dimension_);
  if (place != sources_.end() && *place == source) {
    for (std::size_t i = 0; i < dimension_; ++i) begin[static_cast<std::ptrdiff_t>(i)] += column[i];
    return;
  }
  sources_.insert(place, source);
  factor_.insert(begin, column.begin(), column.end());
}

void Lineage::add(Source source, std::size_t component, double sensitivity) {
  const auto place = std::lower_bound(sources_.begin(), sources_.end(), source);
  const auto k = place - sources_.begin();
  auto begin = factor_.begin() + k * static_cast<std::ptrdiff_t>(dimension_);
  if (place == sources_.end() || *place != source) {
    sources_.insert(place, source);
    begin = factor_.insert(begin, dimension_, 0.0);
  }
  begin[static_cast<std::ptrdiff_t>(component)] += sensitivity;
}

void Lineage::add_noise(Source first, const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  const auto add_factor = [&](const auto& factor) {
    for (Eigen::Index k = 0; k < factor.cols(); ++k) {
      if (factor.col(k).isZero(0.0)) continue;
      Source source = first;
      source.column += static_cast<std::uint32_t>(k);
      add(source, std::span<const double>(factor.col(k).data(), dimension_));
    }
  };
  if (covariance.rows() <= most_components)
    add_factor(noise_factor<ComponentMatrix>(covariance));
  else
    add_factor(noise_factor<Eigen::MatrixXd>(covariance));
}

Eigen::MatrixXd Lineage::covariance() const {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(dimension_), static_cast<Eigen::Index>(dimension_));
  covariance(out);
  return out;
}

void Lineage::covariance(Eigen::Ref<Eigen::MatrixXd> out) const {
  switch (dimension_) {
    case 1:
      return square_fixed<1>(factor_.data(), size(), out);
    case 2:
      return square_fixed<2>(factor_.data(), size(), out);
    case 3:
      return square_fixed<3>(factor_.data(), size(), out);
    case 4:
      return square_fixed<4>(factor_.data(), size(), out);
    case 6:
      return square_fixed<6>(factor_.data(), size(), out);
    default:
      out.noalias() = factor() * factor().transpose();
  }
}

double Lineage::variance(std::size_t component) const {
  double sum = 0;
  for (std::size_t k = 0; k < size(); ++k) sum += column(k)[component] * column(k)[component];
  return sum;
}

double Lineage::standard_deviation(std::size_t component) const {
  return std::sqrt(variance(component));
}

template <typename Foldable>
void Lineage::fold_range(std::size_t begin, std::size_t end, const Foldable& foldable,
                         Source first) {
  const auto count = static_cast<std::size_t>(
      std::count_if(sources_.begin() + static_cast<std::ptrdiff_t>(begin),
                    sources_.begin() + static_cast<std::ptrdiff_t>(end), foldable));
  if (count <= dimension_ || dimension_ > TriangularFactor::most_rows) return;
  TriangularFactor folded(dimension_);
  std::size_t kept = begin;
  bool any_random = false;
  std::int64_t last_tick = persistent_tick;
  for (std::size_t k = begin; k < size(); ++k) {
    if (k < end && foldable(sources_[k])) {
      any_random |= !sources_[k].persistent();
      last_tick = std::max(last_tick, sources_[k].tick);
      folded.add(column(k));
      continue;
    }
    sources_[kept] = sources_[k];
    std::copy_n(factor_.data() + k * dimension_, dimension_, factor_.data() + kept * dimension_);
    ++kept;
  }
  sources_.resize(kept);
  factor_.resize(kept * dimension_);
  first.tick = any_random ? last_tick : persistent_tick;
  for (std::size_t k = 0; k < dimension_; ++k, ++first.column) add(first, folded.column(k));
}

void Lineage::fold(const std::function<bool(const Source&)>& foldable, std::uint32_t folder) {
  // From the last owner to the first, so that the columns still to be folded stay where they are.
  for (std::size_t end = size(); end > 0;) {
    const std::uint32_t owner = sources_[end - 1].owner;
    std::size_t begin = end;
    while (begin > 0 && sources_[begin - 1].owner == owner) --begin;
    const Source first{owner, folded_column | (folder * most_folded), 0};
    const std::size_t size_before = size();
    const auto random = [&](const Source& s) { return !s.persistent() && foldable(s); };
    const auto persistent = [&](const Source& s) { return s.persistent() && foldable(s); };
    fold_range(begin, end, random, first);
    fold_range(begin, end - (size_before - size()), persistent, first);
    end = begin;
  }
}

void Lineage::fold_together(const std::function<bool(const Source&)>& foldable,
                            std::uint32_t folder, std::uint32_t owner) {
  fold_range(0, size(), foldable, {owner, folded_column | (folder * most_folded), 0});
}

void compose(std::span<const LineageTerm> terms, std::size_t rows, Lineage& out) {
  out.dimension_ = rows;
  const LineageTerm* only = nullptr;
  std::size_t carriers = 0;
  for (const LineageTerm& term : terms) {
    if (term.lineage->empty()) continue;
    only = &term;
    ++carriers;
  }
  if (carriers == 1) {
    const Lineage& in = *only->lineage;
    out.sources_.assign(in.sources_.begin(), in.sources_.end());
    out.factor_.resize(rows * in.size());
    multiply<false>(only->jacobian, in.factor_.data(), rows, in.dimension_, in.size(),
                    out.factor_.data());
    return;
  }
  out.sources_.clear();
  out.factor_.clear();
  if (carriers == 0) return;
  constexpr std::size_t most_on_stack = 64;
  std::array<std::size_t, most_on_stack> next_on_stack{};
  std::vector<std::size_t> next_of_many(terms.size() > most_on_stack ? terms.size() : 0);
  const std::span<std::size_t> next =
      next_of_many.empty() ? std::span(next_on_stack).first(terms.size()) : std::span(next_of_many);
  while (out.append_next(terms, next)) continue;
}

void compose_bounded(std::span<const LineageTerm> terms, std::size_t rows, Source first,
                     Lineage& out) {
  const auto m = static_cast<Eigen::Index>(rows);
  Eigen::MatrixXd bound = Eigen::MatrixXd::Zero(m, m);
  double carriers = 0;
  std::vector<Lineage> persistent;
  std::vector<LineageTerm> persistent_terms;
  persistent.reserve(terms.size());
  for (const LineageTerm& term : terms) {
    const Lineage& lineage = *term.lineage;
    const Eigen::Map<const Eigen::MatrixXd> jacobian(
        term.jacobian, m, static_cast<Eigen::Index>(lineage.dimension()));
    Lineage& kept = persistent.emplace_back(lineage.dimension());
    bool any_random = false;
    for (std::size_t k = 0; k < lineage.size(); ++k) {
      if (lineage.sources()[k].persistent()) {
        kept.add(lineage.sources()[k], lineage.column(k));
        continue;
      }
      any_random = true;
      const Eigen::VectorXd column = jacobian * lineage.factor().col(static_cast<Eigen::Index>(k));
      bound += column * column.transpose();
    }
    carriers += any_random ? 1 : 0;
    persistent_terms.push_back({term.jacobian, &kept});
  }
  compose(persistent_terms, rows, out);
  out.add_noise(first, carriers * bound);
}

bool Lineage::append_next(std::span<const LineageTerm> terms, std::span<std::size_t> next) {
  // The least source that is left, and the least among the other terms: up to that one, the term
  // that holds the least stands alone, and its columns are mapped in one go.
  const Source* least = nullptr;
  const Source* limit = nullptr;
  std::size_t holder = 0;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const auto& sources = terms[t].lineage->sources_;
    if (next[t] == sources.size()) continue;
    const Source* candidate = &sources[next[t]];
    if (least == nullptr || *candidate < *least) {
      limit = std::exchange(least, candidate);
      holder = t;
    } else if (limit == nullptr || *candidate < *limit) {
      limit = candidate;
    }
  }
  if (least == nullptr) return false;
  const std::vector<Source>& sources = terms[holder].lineage->sources_;
  if (limit == nullptr || *least < *limit) {
    std::size_t end = next[holder] + 1;
    while (end < sources.size() && (limit == nullptr || sources[end] < *limit)) ++end;
    const std::size_t count = end - next[holder];
    sources_.insert(sources_.end(), least, least + count);
    factor_.resize(factor_.size() + count * dimension_);
    const Lineage& in = *terms[holder].lineage;
    multiply<false>(terms[holder].jacobian, in.factor_.data() + next[holder] * in.dimension_,
                    dimension_, in.dimension_, count,
                    factor_.data() + factor_.size() - count * dimension_);
    next[holder] = end;
    return true;
  }
  const Source shared = *least;
  sources_.push_back(shared);
  factor_.resize(factor_.size() + dimension_);
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const Lineage& in = *terms[t].lineage;
    if (next[t] == in.sources_.size() || in.sources_[next[t]] != shared) continue;
    multiply<true>(terms[t].jacobian, in.factor_.data() + next[t] * in.dimension_, dimension_,
                   in.dimension_, 1, factor_.data() + factor_.size() - dimension_);
    ++next[t];
  }
  return true;
}

Eigen::MatrixXd cross_covariance(const Lineage& a, const Lineage& b) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(a.dimension()),
                                                 static_cast<Eigen::Index>(b.dimension()));
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    const auto order = a.sources()[i] <=> b.sources()[j];
    if (order == 0)
      result += a.factor().col(static_cast<Eigen::Index>(i++)) *
                b.factor().col(static_cast<Eigen::Index>(j++)).transpose();
    else if (order < 0)
      ++i;
    else
      ++j;
  }
  return result;
}

}  // namespace ilss
