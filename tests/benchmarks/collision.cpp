// The geometry of contact: nanoseconds per box, pair and query (docs/developer/architecture.md, layer `collision`).
//
//   build/bin/benchmark_collision [--benchmark_filter=...]
#include "collision/bvh.hpp"
#include "collision/ccd.hpp"
#include "collision/potential.hpp"

#include <cmath>
#include <random>

#include <benchmark/benchmark.h>

namespace {

using namespace pliant;
using Points = std::array<Vector3<double>, 4>;

/// Triangles of a closed wavy surface: n along both directions, with a margin of a tenth of an edge.
std::vector<Box> surface_boxes(int n) {
  const auto point = [n](int i, int j) -> Vector3<double> {
    const double u = 6.283185307179586 * i / n, v = 3.141592653589793 * j / n,
                 r = 1.0 + 0.1 * std::sin(5 * u) * std::sin(4 * v);
    return {r * std::cos(u) * std::sin(v), r * std::sin(u) * std::sin(v), r * std::cos(v)};
  };
  std::vector<Box> boxes;
  const double margin = 0.3 / n;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      boxes.push_back(box_of(margin, point(i, j), point(i + 1, j), point(i + 1, j + 1)));
      boxes.push_back(box_of(margin, point(i, j), point(i + 1, j + 1), point(i, j + 1)));
    }
  }
  return boxes;
}

void count_time(benchmark::State& state, const char* what, double number) {
  state.counters[what] =
      benchmark::Counter(number, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void build(benchmark::State& state) {
  const auto boxes = surface_boxes(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(Bvh(boxes));
  count_time(state, "per_box", static_cast<double>(boxes.size()));
}
BENCHMARK(build)->Arg(70)->Arg(220)->Arg(700)->Unit(benchmark::kMillisecond);

void refit(benchmark::State& state) {
  const auto boxes = surface_boxes(static_cast<int>(state.range(0)));
  Bvh tree(boxes);
  for (auto _ : state) {
    tree.refit(boxes);
    benchmark::ClobberMemory();
  }
  count_time(state, "per_box", static_cast<double>(boxes.size()));
}
BENCHMARK(refit)->Arg(70)->Arg(220)->Arg(700)->Unit(benchmark::kMillisecond);

void query(benchmark::State& state) {
  const auto boxes = surface_boxes(static_cast<int>(state.range(0)));
  const Bvh tree(boxes);
  std::size_t found = 0;
  for (auto _ : state) {
    const auto pairs = overlapping_pairs(tree, [](std::int32_t, std::int32_t) { return true; });
    benchmark::DoNotOptimize(pairs.data());
    found = pairs.size();
  }
  count_time(state, "per_candidate", static_cast<double>(found));
  state.counters["candidates_per_box"] = static_cast<double>(found) / static_cast<double>(boxes.size());
}
BENCHMARK(query)->Arg(70)->Arg(220)->Arg(700)->Unit(benchmark::kMillisecond);

/// A point above a triangle or two edges that cross, near one another, in a motion about as long as their distance.
struct Motion {
  Points x, dx;
};
std::vector<Motion> motions(bool of_edges) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const Points point{{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Points edges{{{-0.5, 0, 0.1}, {0.5, 0, 0.1}, {0, -0.5, 0}, {0, 0.5, 0}}};
  std::vector<Motion> all(1024);
  for (auto& motion : all) {
    motion.x = of_edges ? edges : point;
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 3; ++k) {
        motion.x[i][k] += 0.1 * uniform(engine);
        motion.dx[i][k] = 0.2 * uniform(engine);
      }
    }
  }
  return all;
}

void step_bound(benchmark::State& state) {
  const bool of_edges = state.range(0) != 0;
  const auto all = motions(of_edges);
  for (auto _ : state) {
    double total = 0.0;
    for (const Motion& motion : all) {
      total +=
          of_edges ? max_step_edge_edge(motion.x, motion.dx, {}) : max_step_point_triangle(motion.x, motion.dx, {});
    }
    benchmark::DoNotOptimize(total);
  }
  count_time(state, "per_pair", static_cast<double>(all.size()));
}
BENCHMARK(step_bound)->ArgName("edges")->Arg(0)->Arg(1);

struct Response {
  double energy, pressure, stiffness;
};

/// 0: the gradient, 1: the Hessian, 2: projected, 3: projected by the eigenvalues of all rows.
void potential(benchmark::State& state) {
  const auto all = motions(false);
  const auto law = [](double d) { return Response{d * d, 1.0 / (1.0 + d), 0.1}; };
  for (auto _ : state) {
    for (const Motion& motion : all) {
      const auto at = separation<4>(stencil_of(closest_point_triangle(motion.x)), motion.x);
      Expansion<4> U;
      if (state.range(0) == 0) {
        U = first_order(at, law(at.distance));
      } else {
        U = expand(at, law(at.distance), state.range(0) == 2 ? Definiteness::semidefinite : Definiteness::exact);
      }
      if (state.range(0) == 3) project_to_positive_semidefinite(U);
      benchmark::DoNotOptimize(U);
    }
  }
  count_time(state, "per_pair", static_cast<double>(all.size()));
}
BENCHMARK(potential)->ArgName("kind")->DenseRange(0, 3);

}  // namespace

BENCHMARK_MAIN();
