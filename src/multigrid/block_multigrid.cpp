#include "multigrid/block_multigrid.hpp"

#include "multigrid/block_csr_several.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Dense>
#include <utility>

namespace pliant {
namespace {

/// A level of so many nodes is solved by a dense factorization on every rank, and one of more if it cannot be
/// coarsened.
constexpr PetscInt max_nodes_of_coarsest = 100, max_nodes_that_cannot = 500;
/// A level with more than this part of the nodes of the finer one is not worth its cost.
constexpr double least_coarsening = 0.7;

/// The near-null modes of a matrix; without values if there are none.
Modes modes_of(Mat K, int num_rows) {
  Modes modes;
  MatNullSpace space = nullptr;
  check(MatGetNearNullSpace(K, &space));
  if (space == nullptr) return modes;
  PetscInt number = 0;
  const Vec* vectors = nullptr;
  check(MatNullSpaceGetVecs(space, nullptr, &number, &vectors));
  if (number == 0 || number > Modes::number) return modes;
  modes.values.resize(static_cast<std::size_t>(num_rows) * modes.block_size());
  for (PetscInt m = 0; m < number; ++m) {
    const ConstArrayView mode(vectors[m]);
    if (mode.span().size() != 3 * static_cast<std::size_t>(num_rows)) return {};
    for (int i = 0; i < num_rows; ++i) {
      for (int r = 0; r < 3; ++r) modes.block(i)[3 * m + r] = mode[3 * i + r];
    }
  }
  return modes;
}

}  // namespace

/// The matrix of the coarsest level, factorized.
struct BlockMultigrid::Coarsest {
  Eigen::PartialPivLU<Eigen::MatrixXd> factors;
};

void BlockMultigrid::Deleter::operator()(Coarsest* coarsest) const {
  delete coarsest;
}

std::unique_ptr<BlockMultigrid> BlockMultigrid::make(Mat K, Mat P) {
  std::unique_ptr<BlockMultigrid> multigrid(new BlockMultigrid);
  {
    const std::optional<MatrixBlocks> blocks = MatrixBlocks::of(K);
    if (!blocks) return nullptr;
    const bool lacks_modes = blocks->num_rows() > 0 && modes_of(K, blocks->num_rows()).values.empty();
    if (any_rank(PetscObjectComm(reinterpret_cast<PetscObject>(K)), lacks_modes)) return nullptr;
    multigrid->add_level(blocks->make_halo(), blocks->pattern());
    if (P != nullptr) multigrid->given_ = given_prolongation(P, multigrid->levels_.front().halo());
  }
  if (!multigrid->set_up(K)) return nullptr;
  return multigrid;
}

const BlockSource& BlockMultigrid::values_of(std::size_t level, const BlockSource& finest) const {
  return level == 0 ? finest : *transfers_[level - 1];
}

BlockMultigrid::Depth BlockMultigrid::depth_after(const Aggregates& aggregates, const Halo& halo) {
  const auto number = static_cast<double>(sum(halo.comm(), static_cast<PetscInt64>(aggregates.number)));
  if (number > 0.0 && number <= least_coarsening * static_cast<double>(halo.num_global())) return Depth::deeper;
  return halo.num_global() <= max_nodes_that_cannot ? Depth::coarsest : Depth::hopeless;
}

bool BlockMultigrid::set_up(Mat K) {
  std::optional<MatrixBlocks> finest = MatrixBlocks::of(K);
  if (!finest) return false;
  scale_ = finest->scale_to_one();
  Modes modes = modes_of(K, finest->num_rows());
  for (std::size_t n = 0;; ++n) {
    const BlockSource& values = values_of(n, *finest);
    if (!levels_[n].take(values)) return false;
    if (levels_[n].halo().num_global() <= max_nodes_of_coarsest) return factorize_coarsest(values);
    if (n == 0 && given_) {
      modes = inject(values, modes);
      continue;
    }
    if (aggregates_.size() == n) aggregates_.push_back(aggregate(levels_[n].matrix()));
    switch (depth_after(aggregates_[n], levels_[n].halo())) {
      case Depth::deeper:
        modes = coarsen(n, values, std::move(modes));
        break;
      case Depth::coarsest:
        return factorize_coarsest(values);
      case Depth::hopeless:
        return false;
    }
  }
}

Modes BlockMultigrid::inject(const BlockSource& values, const Modes& modes) {
  const bool is_new = transfers_.empty();
  if (is_new) {
    aggregates_.emplace_back();
    transfers_.push_back(std::make_unique<GalerkinProduct>(levels_.front().matrix(), levels_.front().halo(), *given_));
  }
  GalerkinProduct& transfer = *transfers_.front();
  transfer.compute(levels_.front().matrix(), values);
  if (is_new) add_level(transfer.coarse(), transfer.pattern());
  return injected(modes, *given_, transfer.coarse().first());
}

Modes BlockMultigrid::coarsen(std::size_t n, const BlockSource& values, Modes modes) {
  const Level& level = levels_[n];
  Modes coarse = orthonormalise(aggregates_[n], modes);
  ProlongationRows rows = smoothed_prolongation(level.matrix(), level.halo(), level.inverse_diagonal(),
                                                level.largest_eigenvalue(), aggregates_[n], modes);
  const bool is_new = transfers_.size() == n;
  if (is_new) {
    transfers_.push_back(std::make_unique<GalerkinProduct>(level.matrix(), level.halo(), std::move(rows)));
  } else {
    transfers_[n]->take(rows);
  }
  transfers_[n]->compute(level.matrix(), values);
  if (n > 0) transfers_[n - 1]->forget_sums();
  if (is_new) add_level(transfers_[n]->coarse(), transfers_[n]->pattern());
  return coarse;
}

void BlockMultigrid::add_level(Halo halo, BlockCsr pattern) {
  levels_.emplace_back(std::move(halo), std::move(pattern));
  work_.emplace_back(levels_.back().num_local_entries());
}

bool BlockMultigrid::factorize_coarsest(const BlockSource& values) {
  const Level& level = levels_.back();
  const BlockCsr& A = level.matrix();
  const Halo& halo = level.halo();
  const auto h = static_cast<std::size_t>(A.height), n = static_cast<std::size_t>(halo.num_global()) * h;
  std::vector<double> rows(level.num_own_entries() * n), block(A.block_size());
  for (int row = 0; row < A.num_rows(); ++row) {
    for (std::size_t k = A.begin(row); k < A.end(row); ++k) {
      values.read(row, k - A.begin(row), block.data());
      const std::size_t column = static_cast<std::size_t>(halo.global(A.columns[k])) * h;
      for (std::size_t r = 0; r < h; ++r) {
        for (std::size_t c = 0; c < h; ++c)
          rows[(static_cast<std::size_t>(row) * h + r) * n + column + c] = block[c * h + r];
      }
    }
  }
  if (!transfers_.empty()) transfers_.back()->forget_sums();
  const std::vector<double> all = gathered(halo.comm(), rows);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto size = static_cast<Eigen::Index>(n);
  coarsest_.reset(
      new Coarsest{Eigen::PartialPivLU<Eigen::MatrixXd>(Eigen::Map<const RowMajor>(all.data(), size, size))});
  return std::isfinite(coarsest_->factors.matrixLU().sum());
}

double BlockMultigrid::operator_complexity() const {
  double finest = 0.0, all = 0.0;
  for (const Level& level : levels_) {
    const auto comm = level.halo().comm();
    const double entries = sum(comm, static_cast<double>(level.matrix().columns.size() * level.matrix().block_size()));
    if (finest == 0.0) finest = entries;
    all += entries;
  }
  return finest > 0.0 ? all / finest : 1.0;
}

template <class T>
void BlockMultigrid::solve_coarsest(Level::Work<T>& work) {
  const Level& level = levels_.back();
  constexpr Eigen::Index lanes = sizeof(T) / sizeof(float);
  const std::span<const float> own(reinterpret_cast<const float*>(work.b.data()), lanes * level.num_own_entries());
  const std::vector<float> all = gathered(level.halo().comm(), std::vector<float>(own.begin(), own.end()));
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, lanes, lanes == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
  const Eigen::Matrix<double, Eigen::Dynamic, lanes> b =
      Eigen::Map<const Rows>(all.data(), static_cast<Eigen::Index>(all.size()) / lanes, lanes).template cast<double>();
  const Eigen::Matrix<double, Eigen::Dynamic, lanes> x = coarsest_->factors.solve(b);
  const Eigen::Index begin = level.halo().first() * level.matrix().height;
  const auto count = static_cast<Eigen::Index>(level.num_own_entries());
  Eigen::Map<Rows>(reinterpret_cast<float*>(work.x.data()), count, lanes) =
      x.middleRows(begin, count).template cast<float>();
}

template <class T>
void BlockMultigrid::cycle(std::size_t n, Works<T>& works) {
  Level::Work<T>& work = works[n];
  if (n + 1 == levels_.size()) return solve_coarsest(work);
  const Level& level = levels_[n];
  Level::Work<T>& coarse = works[n + 1];
  const GalerkinProduct& transfer = *transfers_[n];
  const auto own = [&level](std::vector<T>& v) { return std::span(v).first(level.num_own_entries()); };
  level.smooth_from_zero(work);
  level.residual(work);
  multiply_transposed(transfer.prolongation(), own(work.r), coarse.b);
  transfer.coarse().add_to_owners(std::span(coarse.b), transfer.prolongation().width);
  cycle(n + 1, works);
  transfer.coarse().fetch(std::span(coarse.x), transfer.prolongation().width);
  add_product(transfer.prolongation(), coarse.x, own(work.x));
  level.smooth_further(work);
}

void BlockMultigrid::apply(Vec b, Vec x) {
  PetscReal size = 0.0;
  check(VecNorm(b, NORM_INFINITY, &size));
  if (!(size > 0.0)) return check(VecCopy(b, x));
  Level::Work<float>& work = work_.front();
  {
    const ConstArrayView values(b);
    std::ranges::transform(values.span(), work.b.begin(), [size](double v) { return static_cast<float>(v / size); });
  }
  cycle(0, work_);
  const double by = size / scale_;
  const ArrayView values(x);
  std::transform(values.span().begin(), values.span().end(), work.x.begin(), values.span().begin(),
                 [by](double, float v) { return by * v; });
}

void BlockMultigrid::apply(std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
  for (std::size_t n = several_.size(); n < levels_.size(); ++n) several_.emplace_back(levels_[n].num_local_entries());
  SeveralDoubles size(0.0);
  for (const SeveralDoubles& entry : b) size = std::experimental::max(size, std::experimental::abs(entry));
  const MPI_Comm comm = levels_.front().halo().comm();
  for (std::size_t lane = 0; lane < num_several; ++lane) {
    const double largest = maximum(comm, static_cast<double>(size[lane]));
    size[lane] = largest > 0.0 ? largest : 1.0;
  }
  const SeveralDoubles down = 1.0 / size, up = size / scale_;
  Level::Work<SeveralFloats>& work = several_.front();
  for (std::size_t i = 0; i < b.size(); ++i) work.b[i] = to_floats(down * b[i]);
  cycle(0, several_);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = up * to_doubles(work.x[i]);
}

}  // namespace pliant
