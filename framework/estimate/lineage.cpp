#include "framework/estimate/lineage.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

namespace ilss {
namespace {

// Marks columns made by folding; their low bits are folder * 64 + index.
constexpr std::uint32_t folded_column = 0x80000000u;

/// out (rows x K) += J (rows x columns) * in (columns x K) for a block of K whole columns.
template <std::size_t Rows>
void multiply_add_fixed(const double* jacobian, const double* in, std::size_t columns,
                        std::size_t k_count, double* out) {
  for (std::size_t k = 0; k < k_count; ++k, in += columns, out += Rows) {
    std::array<double, Rows> sum;
    for (std::size_t i = 0; i < Rows; ++i) sum[i] = out[i];
    for (std::size_t j = 0; j < columns; ++j)
      for (std::size_t i = 0; i < Rows; ++i) sum[i] += jacobian[j * Rows + i] * in[j];
    for (std::size_t i = 0; i < Rows; ++i) out[i] = sum[i];
  }
}

void multiply_add(const double* jacobian, const double* in, std::size_t rows, std::size_t columns,
                  std::size_t k_count, double* out) {
  switch (rows) {
    case 1:
      return multiply_add_fixed<1>(jacobian, in, columns, k_count, out);
    case 2:
      return multiply_add_fixed<2>(jacobian, in, columns, k_count, out);
    case 3:
      return multiply_add_fixed<3>(jacobian, in, columns, k_count, out);
    case 4:
      return multiply_add_fixed<4>(jacobian, in, columns, k_count, out);
    case 6:
      return multiply_add_fixed<6>(jacobian, in, columns, k_count, out);
    default:
      break;
  }
  for (std::size_t k = 0; k < k_count; ++k, in += columns, out += rows)
    for (std::size_t j = 0; j < columns; ++j)
      for (std::size_t i = 0; i < rows; ++i) out[i] += jacobian[j * rows + i] * in[j];
}

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
  // A diagonal covariance is its own factor; otherwise Cholesky, and where it is singular the
  // symmetric square root, which rounding cannot make indefinite.
  const Eigen::Index m = covariance.rows();
  Eigen::MatrixXd factor;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(covariance);
  if (cholesky.info() == Eigen::Success) {
    factor = cholesky.matrixL();
  } else {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
    factor = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  }
  for (Eigen::Index k = 0; k < m; ++k) {
    if (factor.col(k).isZero(0.0)) continue;
    Source source = first;
    source.column += static_cast<std::uint32_t>(k);
    add(source, std::span<const double>(factor.col(k).data(), static_cast<std::size_t>(m)));
  }
}

Eigen::MatrixXd Lineage::covariance() const {
  const auto g = factor();
  return g * g.transpose();
}

double Lineage::variance(std::size_t component) const {
  double sum = 0;
  for (std::size_t k = 0; k < size(); ++k) sum += column(k)[component] * column(k)[component];
  return sum;
}

double Lineage::standard_deviation(std::size_t component) const {
  return std::sqrt(variance(component));
}

void Lineage::remove_marked(const std::vector<char>& gone) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < sources_.size(); ++k) {
    if (gone[k]) continue;
    if (kept != k) {
      sources_[kept] = sources_[k];
      std::copy_n(factor_.begin() + static_cast<std::ptrdiff_t>(k * dimension_), dimension_,
                  factor_.begin() + static_cast<std::ptrdiff_t>(kept * dimension_));
    }
    ++kept;
  }
  sources_.resize(kept);
  factor_.resize(kept * dimension_);
}

void Lineage::fold_columns(std::span<const std::size_t> columns, Source first) {
  if (columns.size() <= dimension_) return;
  const auto m = static_cast<Eigen::Index>(dimension_);
  Eigen::MatrixXd transposed(static_cast<Eigen::Index>(columns.size()), m);
  std::vector<char> gone(size(), 0);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    transposed.row(static_cast<Eigen::Index>(c)) =
        factor().col(static_cast<Eigen::Index>(columns[c]));
    gone[columns[c]] = 1;
  }
  remove_marked(gone);
  // Gᵀ = Q R, so G Gᵀ = Rᵀ R and Rᵀ (M x M) serves as the folded factor.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(transposed);
  const Eigen::MatrixXd lower =
      Eigen::MatrixXd(qr.matrixQR().topRows(m).triangularView<Eigen::Upper>()).transpose();
  for (Eigen::Index k = 0; k < m; ++k) {
    Source source = first;
    source.column += static_cast<std::uint32_t>(k);
    add(source, std::span<const double>(lower.col(k).data(), dimension_));
  }
}

void Lineage::fold(const std::function<bool(const Source&)>& foldable, std::uint32_t folder) {
  std::map<std::uint32_t, std::vector<std::size_t>> columns_of;
  for (std::size_t k = 0; k < size(); ++k)
    if (foldable(sources_[k])) columns_of[sources_[k].owner].push_back(k);
  // Folding one owner moves the columns of the others, so they are found anew by name.
  std::map<std::uint32_t, std::vector<Source>> sources_of;
  for (const auto& [owner, columns] : columns_of) {
    if (columns.size() <= dimension_) continue;
    for (const std::size_t k : columns) sources_of[owner].push_back(sources_[k]);
  }
  for (const auto& [owner, sources] : sources_of) {
    std::vector<std::size_t> columns;
    for (const Source& source : sources)
      columns.push_back(static_cast<std::size_t>(
          std::lower_bound(sources_.begin(), sources_.end(), source) - sources_.begin()));
    fold_columns(columns, {owner, folded_column | (folder * 64), sources.back().tick});
  }
}

void Lineage::fold_together(const std::function<bool(const Source&)>& foldable,
                            std::uint32_t folder, std::uint32_t owner) {
  std::vector<std::size_t> columns;
  std::int64_t tick = 0;
  for (std::size_t k = 0; k < size(); ++k) {
    if (!foldable(sources_[k])) continue;
    columns.push_back(k);
    tick = std::max(tick, sources_[k].tick);
  }
  fold_columns(columns, {owner, folded_column | (folder * 64), tick});
}

void compose(std::span<const LineageTerm> terms, std::size_t rows, Lineage& out) {
  out.reset(rows);
  const LineageTerm* only = nullptr;
  std::size_t carriers = 0;
  for (const LineageTerm& term : terms) {
    if (term.lineage->empty()) continue;
    only = &term;
    ++carriers;
  }
  if (carriers == 0) return;
  if (carriers == 1) {
    const Lineage& in = *only->lineage;
    out.sources_.assign(in.sources_.begin(), in.sources_.end());
    out.factor_.assign(rows * in.size(), 0.0);
    multiply_add(only->jacobian, in.factor_.data(), rows, in.dimension_, in.size(),
                 out.factor_.data());
    return;
  }
  // Merge of the sorted source lists; each output column gathers that source from every term.
  constexpr std::size_t most_terms = 64;
  std::array<std::size_t, most_terms> next_inline{};
  std::vector<std::size_t> next_many;
  if (terms.size() > most_terms) next_many.resize(terms.size());
  std::size_t* next = terms.size() > most_terms ? next_many.data() : next_inline.data();
  for (;;) {
    const Source* least = nullptr;
    for (std::size_t t = 0; t < terms.size(); ++t) {
      const auto& sources = terms[t].lineage->sources_;
      if (next[t] < sources.size() && (least == nullptr || sources[next[t]] < *least))
        least = &sources[next[t]];
    }
    if (least == nullptr) return;
    const Source source = *least;
    out.sources_.push_back(source);
    out.factor_.resize(out.factor_.size() + rows, 0.0);
    double* column = out.factor_.data() + out.factor_.size() - rows;
    for (std::size_t t = 0; t < terms.size(); ++t) {
      const Lineage& in = *terms[t].lineage;
      if (next[t] >= in.sources_.size() || in.sources_[next[t]] != source) continue;
      multiply_add(terms[t].jacobian, in.factor_.data() + next[t] * in.dimension_, rows,
                   in.dimension_, 1, column);
      ++next[t];
    }
  }
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
