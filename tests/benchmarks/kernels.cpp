// The hot loops on one rank, all terms, with insertion: tetrahedra per second, and which part of what one core can do
// at best they reach. docs/performance.md, "Kernels", tells how operations and bytes are counted.
//
//   build/bin/benchmark_kernels [--benchmark_filter=...]
#include "benchmarks/counted.hpp"
#include "energy/equation/incremental_potential.hpp"
#include "energy/volume/elastic.hpp"
#include "energy/volume/inertia.hpp"
#include "material/energy_change.hpp"
#include "material/registry.hpp"
#include "mesh/box_mesh.hpp"
#include "petsc/array_view.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

namespace {

using namespace pliant;

/// Seconds of one call: the least of several, after one to warm up.
template <class Work>
double seconds(const Work& work) {
  constexpr int calls = 10;
  work();
  double best = HUGE_VAL;
  for (int call = 0; call < calls; ++call) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

/// What one core does at best.
struct Machine {
  double operations;  ///< [1/s]: multiply-adds of packs, each two per lane
  double bandwidth;   ///< [B/s]: a = b + s c over arrays far larger than the caches, 24 bytes an entry
};

Machine measure_machine() {
  constexpr std::size_t size = 20'000'000;
  std::vector<double> a(size, 1.0), b(size, 2.0), c(size, 3.0);
  const double triad = seconds([&] {
    for (std::size_t i = 0; i < size; ++i) a[i] = b[i] + 0.5 * c[i];
  });
  benchmark::DoNotOptimize(a.data());
  constexpr int rounds = 1'000'000, chains = 12;  // as many as hide the latency of an operation
  Pack factor = 1.0 - 1e-9, shift = 1e-9;
  benchmark::DoNotOptimize(factor);
  benchmark::DoNotOptimize(shift);
  const double chain = seconds([&] {
    std::array<Pack, chains> x;
    x.fill(1.0);
    benchmark::DoNotOptimize(x);
    for (int round = 0; round < rounds; ++round) {
      for (int k = 0; k < chains; ++k) x[k] = x[k] * factor + shift;
    }
    benchmark::DoNotOptimize(x);
  });
  return {2.0 * rounds * chains * pack_size / chain, 24.0 * size / triad};
}

const Machine& machine() {
  static const Machine measured = measure_machine();
  return measured;
}

/// Work on one tetrahedron.
struct Work {
  double operations;
  double bytes;
};

/// Operations of a law at one point.
struct LawOperations {
  double psi_change, P, tangent;
};

LawOperations operations_of_law(const ElasticLawSpec& spec) {
  Tensor3<Counted> H, dH;
  for (std::size_t i = 0; i < 9; ++i) {
    H.a[i] = 0.02 * std::sin(3.0 * i + 1.0);
    dH.a[i] = 1e-4 * std::cos(2.0 * i);
  }
  return std::visit(
      [&](const auto& law) -> LawOperations {
        const auto count = [](const auto& work) { return static_cast<double>(operations_of(work)); };
        return {count([&] { energy_change(law, H, dH); }), count([&] { law.P(H); }),
                count([&] { law.linearize(H).tangent(); })};
      },
      instantiate(spec));
}

enum class Kernel { residual, energy, hessian, projected_hessian, mass_product };
constexpr std::array<std::pair<Kernel, const char*>, 5> kernels{{{Kernel::residual, "residual"},
                                                                 {Kernel::energy, "energy"},
                                                                 {Kernel::hessian, "hessian"},
                                                                 {Kernel::projected_hessian, "projected-hessian"},
                                                                 {Kernel::mass_product, "mass-product"}}};

/// A cube of bricks^3 x 6 tetrahedra in a smooth random-like state.
template <int Order>
class Body {
 public:
  Body(int bricks, const ElasticLawSpec& law) : law_(law) {
    const auto file = std::filesystem::temp_directory_path() / "pliant_benchmark.msh";
    test::write_box_msh(file.string(), {1.0, 1.0, 1.0}, {bricks, bricks, bricks});
    MeshSource source;
    source.file = file.string();
    mesh_ = read_mesh(MPI_COMM_WORLD, source);
    std::filesystem::remove(file);
    layout_ = make_layout(mesh_, Order);
    pattern_ = std::make_unique<BlockPattern>(layout_);
    groups_ = make_cell_groups<Order>(layout_, *pattern_, std::vector<int>(layout_.num_local_cells, 0),
                                      {elastic_quadrature_degree(law.traits(), Order)});
    elastic_ = make_elastic_term<Order>(law, groups_, 0, layout_.num_owned_nodes);
    inertia_ = make_inertia<Order>(layout_, *pattern_, groups_, {1000.0}, Mass::consistent);
    const std::vector<char> free(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0);
    potential_ = std::make_unique<IncrementalPotential>(
        layout_, *pattern_, std::vector<const EnergyTerm*>{elastic_.get(), inertia_.get()}, free);
    for (Handle<Vec>* v : {&q_, &r_, &zero_}) *v = make_vector(layout_);
    {
      const ArrayView u(q_.get());
      for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
        const auto X = layout_.position(a);
        for (int i = 0; i < 3; ++i) u[3 * a + i] = 0.02 * std::sin(3.0 * X[(i + 1) % 3] + i);
      }
    }
    K_ = potential_->make_hessian();
    potential_->begin_stage({0.0, 0.01, zero_.get(), zero_.get()});
    x_.assign(layout_.coordinates.size(), 1.0);
    y_.assign(x_.size(), 0.0);
  }

  double num_cells() const { return layout_.num_owned_cells; }

  void run(Kernel kernel) {
    switch (kernel) {
      case Kernel::residual:
        return potential_->gradient(q_.get(), r_.get());
      case Kernel::energy:
        return benchmark::DoNotOptimize(potential_->value(q_.get()));
      case Kernel::hessian:
        return potential_->hessian(q_.get(), K_.get(), Projection::none);
      case Kernel::projected_hessian:
        return potential_->hessian(q_.get(), K_.get(), Projection::positive_semidefinite);
      case Kernel::mass_product:
        return inertia_->mass().add_times(x_, y_);
    }
  }

  /// Of a projected Hessian only what it has in common with an exact one: its eigenproblems are not counted.
  Work work(Kernel kernel) const {
    const LawOperations law = operations_of_law(law_);
    const double points = groups_.front().rule.size();
    // Per tetrahedron: nodes, blocks of K, bytes of what a cell has of its own.
    const double nodes = layout_.num_owned_nodes / num_cells();
    const double blocks = static_cast<double>(pattern_->diagonal().nodes.size()) / num_cells();
    const double cell = 4.0 * n + 80.0;
    constexpr double vector = 24.0, mass = 12.0, block = 72.0;
    // grad u; P pulled back and tested with n gradients; D_km, and the terms dN_a/dl_k D_km dN_b/dl_m.
    constexpr double gradient = 21.0 * (n - 1) + 45.0, force = 54.0 + 18.0 * n;
    constexpr double linear_matrix = 864.0, matrix_terms = 19.0 * (Order == 1 ? 10 : 142);
    constexpr double insertion = 9.0 * n * n;
    switch (kernel) {
      case Kernel::residual:
        return {points * (gradient + law.P + force) + 6.0 * blocks, cell + 8.0 * vector * nodes + mass * blocks};
      case Kernel::energy:
        return {points * (2.0 * gradient + law.psi_change) + 6.0 * blocks, cell + 7.0 * vector * nodes + mass * blocks};
      case Kernel::hessian:
      case Kernel::projected_hessian:
        return {points * (gradient + law.tangent + linear_matrix + matrix_terms) + insertion + blocks,
                cell + 4.0 * n * n + vector * nodes + 3.0 * block * blocks + 8.0 * blocks};
      case Kernel::mass_product:
        return {6.0 * blocks, mass * blocks + 3.0 * vector * nodes};
    }
    throw std::logic_error("unknown kernel");
  }

 private:
  static constexpr int n = Tet<Order>::num_nodes;

  ElasticLawSpec law_;
  Mesh mesh_;
  NodeLayout layout_;
  std::unique_ptr<BlockPattern> pattern_;
  CellGroups<Order> groups_;
  std::unique_ptr<ElasticTerm> elastic_;
  std::unique_ptr<Inertia> inertia_;
  std::unique_ptr<IncrementalPotential> potential_;
  Handle<Vec> q_, r_, zero_;
  Handle<Mat> K_;
  std::vector<double> x_, y_;
};

template <int Order>
void measure(benchmark::State& state, std::size_t row, Kernel kernel) {
  Body<Order> body(Order == 1 ? 20 : 12, typical_law(row));
  const Work work = body.work(kernel);
  body.run(kernel);
  for (auto _ : state) body.run(kernel);
  const double cells = body.num_cells();
  const auto rate = [&](double of_one_run) {
    return benchmark::Counter(of_one_run, benchmark::Counter::kIsIterationInvariantRate);
  };
  state.counters["tetrahedra"] = rate(cells);
  state.counters["operations"] = rate(cells * work.operations);
  state.counters["bytes"] = rate(cells * work.bytes);
  // Parts of the time that operations and transfers would take at the machine's best.
  state.counters["of_peak"] = rate(cells * work.operations / machine().operations);
  state.counters["of_bandwidth"] = rate(cells * work.bytes / machine().bandwidth);
}

template <int Order>
void add_all() {
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    for (const auto& [kernel, name] : kernels) {
      benchmark::RegisterBenchmark(fmt::format("P{}/{}/{}", Order, elastic_laws()[row].name, name).c_str(),
                                   measure<Order>, row, kernel);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const Session session(argv[0], {});
  benchmark::AddCustomContext("multiply-adds [GFlop/s]", fmt::format("{:.1f}", 1e-9 * machine().operations));
  benchmark::AddCustomContext("triad [GB/s]", fmt::format("{:.1f}", 1e-9 * machine().bandwidth));
  add_all<1>();
  add_all<2>();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
