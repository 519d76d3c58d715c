/// How objects declare the state that a checkpoint must hold, so that a resumed run continues exactly.
#pragma once

#include "petsc/handle.hpp"

#include <array>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace pliant {

/// What the entries of a vector belong to.
enum class Entries {
  nodes,      ///< three per node: configurations, velocities, accelerations, forces
  internal,   ///< internal variables of the material
  pressures,  ///< pressures that are unknowns
};

/// An object with state has a method `keep(Archive&)` that names all of it: a writing archive stores the values, a
/// reading one restores them. One declaration serves both and stands next to the members. State that follows from the
/// input, and scratch values of a step, are not kept.
///
/// Names are paths; `Archive::Section` opens a level. Everything is collective: every rank keeps the same items in the
/// same order, and numbers with the same values.
class Archive {
 public:
  virtual ~Archive() = default;

  /// Whether the archive restores (reads) rather than stores.
  virtual bool restores() const = 0;

  /// A number, exact up to 2^53 if it is whole.
  template <class T>
  requires std::is_arithmetic_v<T>
  void number(const std::string& name, T& x) {
    auto value = static_cast<double>(x);
    exchange(path_ + name, std::span(&value, 1));
    x = static_cast<T>(value);
  }
  /// A list of numbers; on restoring, as many as were stored.
  void numbers(const std::string& name, std::span<double> x) { exchange(path_ + name, x); }
  /// The owned entries; ghosts are left to the owner of the vector.
  void vector(const std::string& name, Entries entries, Vec x) { exchange(path_ + name, entries, x); }

  /// While it lives, names are relative to `name`.
  class Section {
   public:
    Section(Archive& archive, const std::string& name) : archive_(archive), length_(archive.path_.size()) {
      archive_.path_ += name + ".";
    }
    ~Section() { archive_.path_.resize(length_); }
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;

   private:
    Archive& archive_;
    std::size_t length_;
  };

 protected:
  virtual void exchange(const std::string& path, std::span<double> x) = 0;
  virtual void exchange(const std::string& path, Entries entries, Vec x) = 0;

 private:
  std::string path_;
};

}  // namespace pliant
