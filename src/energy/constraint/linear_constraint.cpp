#include "energy/constraint/linear_constraint.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Coefficients that cancel to less than this fraction of their summands are rounding.
constexpr double cancellation = 1e-12;
/// Relative tolerance: prescribed displacements that differ by less agree.
constexpr double agreement = 1e-9;
/// A coefficient nearly as large as the largest may be the pivot if it comes first.
constexpr double nearly = 0.999;
/// A preferred pivot has at least this fraction of the largest coefficient.
constexpr double not_small = 0.1;

/// sum of c_k q_k - given, while slaves are substituted. The entries are in the order in which they were added: their
/// numbers depend on the ranks.
struct Row {
  struct Summed {
    PetscInt entry;
    double coefficient, size;  // of its summands
  };
  std::vector<Summed> entries;
  std::vector<GivenTerm> given;

  const Summed* find(PetscInt entry) const {
    const auto found = place_.find(entry);
    return found == place_.end() ? nullptr : &entries[found->second];
  }
  void add(double factor, std::span<const ConstraintEntry> more) {
    for (const auto& [entry, coefficient] : more) {
      const auto [place, is_new] = place_.try_emplace(entry, entries.size());
      if (is_new) entries.push_back({entry, 0.0, 0.0});
      Summed& sum = entries[place->second];
      sum.coefficient += factor * coefficient;
      sum.size += std::abs(factor * coefficient);
    }
  }
  void add(double factor, std::span<const GivenTerm> more) {
    for (GivenTerm term : more) {
      term.weight *= factor;
      const auto same = std::ranges::find_if(given, [&](const GivenTerm& g) {
        return g.source == term.source && g.component == term.component && g.X == term.X;
      });
      if (same == given.end()) {
        given.push_back(term);
      } else {
        same->weight += term.weight;
      }
    }
  }
  void drop_rounding() {
    std::erase_if(entries, [](const Summed& e) { return std::abs(e.coefficient) <= cancellation * e.size; });
    std::erase_if(given, [](const GivenTerm& g) { return std::abs(g.weight) <= cancellation; });
    place_.clear();
    for (std::size_t k = 0; k < entries.size(); ++k) place_[entries[k].entry] = k;
  }

 private:
  std::unordered_map<PetscInt, std::size_t> place_;
};

/// In the order in which the constraint lists its entries, then any others.
PetscInt choose_pivot(const Row& row, const LinearConstraint& constraint, std::optional<PetscInt> preferred) {
  double largest = 0.0;
  for (const auto& e : row.entries) largest = std::max(largest, std::abs(e.coefficient));
  const auto exceeds = [&](PetscInt entry, double fraction) {
    const auto* found = row.find(entry);
    return found != nullptr && std::abs(found->coefficient) >= fraction * largest;
  };
  if (preferred && exceeds(*preferred, not_small)) return *preferred;
  for (const auto& e : constraint.entries) {
    if (exceeds(e.entry, nearly)) return e.entry;
  }
  return std::ranges::find_if(row.entries, [&](const auto& e) { return exceeds(e.entry, nearly); })->entry;
}

}  // namespace

void Eliminator::add(const LinearConstraint& constraint, std::optional<PetscInt> preferred) {
  Row row;
  row.add(-1.0, constraint.given);
  std::size_t implied_by = constraint.source;
  for (const ConstraintEntry& e : constraint.entries) {
    const Slave* known = find(e.entry);
    if (known == nullptr) {
      row.add(1.0, std::span(&e, 1));
    } else {
      row.add(e.coefficient, known->masters);
      row.add(e.coefficient, known->given);
      implied_by = known->source;
    }
  }
  row.drop_rounding();
  if (row.entries.empty()) {
    if (!vanishes(row.given)) result_.conflicts.emplace_back(implied_by, constraint.source);
    return;
  }
  const PetscInt pivot = choose_pivot(row, constraint, preferred);
  const double factor = -1.0 / row.find(pivot)->coefficient;
  Slave slave{pivot, {}, {}, constraint.source};
  for (const auto& [entry, coefficient, size] : row.entries) {
    if (entry != pivot) slave.masters.push_back({entry, factor * coefficient});
  }
  slave.given = std::move(row.given);
  for (GivenTerm& term : slave.given) term.weight *= factor;
  put_into_others(slave);
  for (const auto& master : slave.masters) slaves_of_[master.entry].insert(result_.slaves.size());
  slave_of_[pivot] = result_.slaves.size();
  result_.slaves.push_back(std::move(slave));
}

const Slave* Eliminator::find(PetscInt entry) const {
  const auto found = slave_of_.find(entry);
  return found == slave_of_.end() ? nullptr : &result_.slaves[found->second];
}

Elimination Eliminator::take() && {
  std::ranges::sort(result_.conflicts);
  const auto repeated = std::ranges::unique(result_.conflicts);
  result_.conflicts.erase(repeated.begin(), repeated.end());
  return std::move(result_);
}

bool Eliminator::vanishes(const std::vector<GivenTerm>& terms) const {
  return std::ranges::all_of(times_, [&](double t) {
    double sum = 0.0, size = 0.0;
    for (const GivenTerm& term : terms) {
      const double u = term.weight * given_[term.source](term.component, term.X, t);
      sum += u;
      size += std::abs(u);
    }
    return std::abs(sum) <= agreement * size;
  });
}

void Eliminator::put_into_others(const Slave& slave) {
  const auto followers = slaves_of_.find(slave.entry);
  if (followers == slaves_of_.end()) return;
  for (const std::size_t s : followers->second) {
    Slave& other = result_.slaves[s];
    Row row;
    double coefficient = 0.0;
    for (const ConstraintEntry& master : other.masters) {
      if (master.entry == slave.entry) {
        coefficient = master.coefficient;
      } else {
        row.add(1.0, std::span(&master, 1));
      }
    }
    row.add(1.0, other.given);
    row.add(coefficient, slave.masters);
    row.add(coefficient, slave.given);
    row.drop_rounding();
    other.masters.clear();
    for (const auto& [entry, c, size] : row.entries) {
      other.masters.push_back({entry, c});
      slaves_of_[entry].insert(s);
    }
    other.given = std::move(row.given);
  }
  slaves_of_.erase(slave.entry);
}

Elimination eliminate(std::span<const LinearConstraint> constraints, std::span<const GivenDisplacement> given,
                      std::span<const double> times) {
  Eliminator eliminator(given, times);
  for (const LinearConstraint& constraint : constraints) eliminator.add(constraint);
  return std::move(eliminator).take();
}

std::vector<LinearConstraint> gathered(MPI_Comm comm, std::span<const LinearConstraint> mine) {
  struct Head {
    std::size_t source, num_entries, num_given;
  };
  std::vector<Head> my_heads;
  std::vector<ConstraintEntry> my_entries;
  std::vector<GivenTerm> my_given;
  for (const LinearConstraint& c : mine) {
    my_heads.push_back({c.source, c.entries.size(), c.given.size()});
    my_entries.insert(my_entries.end(), c.entries.begin(), c.entries.end());
    my_given.insert(my_given.end(), c.given.begin(), c.given.end());
  }
  const auto heads = gathered(comm, my_heads);
  const auto entries = gathered(comm, my_entries);
  const auto given = gathered(comm, my_given);
  std::vector<LinearConstraint> result;
  auto entry = entries.begin();
  auto term = given.begin();
  for (const Head& head : heads) {
    LinearConstraint& c = result.emplace_back();
    c.source = head.source;
    c.entries.assign(entry, entry + static_cast<std::ptrdiff_t>(head.num_entries));
    c.given.assign(term, term + static_cast<std::ptrdiff_t>(head.num_given));
    entry += static_cast<std::ptrdiff_t>(head.num_entries);
    term += static_cast<std::ptrdiff_t>(head.num_given);
  }
  return result;
}

}  // namespace pliant
