// Tetrahedra per second of the hot loops on one rank: residual, energy and Hessian with insertion, all terms.
//
//   build/bin/benchmark_kernels [--benchmark_filter=...]
#include "energy/elastic.hpp"
#include "energy/incremental_potential.hpp"
#include "energy/inertia.hpp"
#include "mesh/box_mesh.hpp"
#include "petsc/array_view.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include <benchmark/benchmark.h>

namespace {

using namespace pliant;

/// A cube of n^3 x 6 tetrahedra in a smooth random-like state.
template <int Order>
class Body {
 public:
  Body(int n, const char* law_name) {
    const auto file = std::filesystem::temp_directory_path() / "pliant_benchmark.msh";
    testing::write_box_msh(file.string(), {1.0, 1.0, 1.0}, {n, n, n});
    MeshSource source;
    source.file = file.string();
    mesh_ = read_mesh(MPI_COMM_WORLD, source);
    std::filesystem::remove(file);
    layout_ = make_layout(mesh_, Order);
    pattern_ = std::make_unique<BlockPattern>(layout_);
    const auto law = typical_law(static_cast<std::size_t>(
        std::ranges::find(elastic_laws(), std::string_view(law_name), &LawInfo::name) - elastic_laws().begin()));
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
  }

  void residual() { potential_->gradient(q_.get(), r_.get()); }
  void energy() { benchmark::DoNotOptimize(potential_->value(q_.get())); }
  void hessian() { potential_->hessian(q_.get(), K_.get(), Projection::none); }
  PetscInt num_cells() const { return layout_.num_owned_cells; }

 private:
  Mesh mesh_;
  NodeLayout layout_;
  std::unique_ptr<BlockPattern> pattern_;
  CellGroups<Order> groups_;
  std::unique_ptr<ElasticTerm> elastic_;
  std::unique_ptr<Inertia> inertia_;
  std::unique_ptr<IncrementalPotential> potential_;
  Handle<Vec> q_, r_, zero_;
  Handle<Mat> K_;
};

template <int Order, void (Body<Order>::*work)()>
void run(benchmark::State& state, const char* law) {
  Body<Order> body(Order == 1 ? 20 : 12, law);
  (body.*work)();
  for (auto _ : state) (body.*work)();
  state.counters["tetrahedra"] = benchmark::Counter(body.num_cells(), benchmark::Counter::kIsIterationInvariantRate);
}

template <int Order>
void add_all(const std::string& order) {
  for (const auto& law : elastic_laws()) {
    const std::string prefix = order + "/" + std::string(law.name);
    const char* name = law.name.data();
    benchmark::RegisterBenchmark((prefix + "/residual").c_str(), run<Order, &Body<Order>::residual>, name);
    benchmark::RegisterBenchmark((prefix + "/energy").c_str(), run<Order, &Body<Order>::energy>, name);
    benchmark::RegisterBenchmark((prefix + "/hessian").c_str(), run<Order, &Body<Order>::hessian>, name);
  }
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const Session session(argv[0], {});
  add_all<1>("P1");
  add_all<2>("P2");
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
