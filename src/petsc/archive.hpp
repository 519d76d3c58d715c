/// How objects say what they must remember to go on later exactly as if they had never stopped.
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

/// An object that keeps a state has a method `keep(Archive&)`, which names all of it: an archive that stores writes it
/// down, one that restores puts in what was written. So there is one declaration for both, next to the members. What
/// follows from the input, and what a step leaves in passing, is not kept.
///
/// Names are paths, `Archive::Section` opens a level. Everything is collective: every rank keeps the same things in the
/// same order, numbers with the same values.
class Archive {
 public:
  virtual ~Archive() = default;

  /// Whether this is the way back.
  virtual bool restores() const = 0;

  /// A number, exact up to 2^53 if it is whole.
  template <class T>
  requires std::is_arithmetic_v<T>
  void number(const std::string& name, T& x) {
    auto value = static_cast<double>(x);
    exchange(path_ + name, std::span(&value, 1));
    x = static_cast<T>(value);
  }
  /// Numbers, as many on the way back as there were.
  void numbers(const std::string& name, std::span<double> x) { exchange(path_ + name, x); }
  /// The owned entries; ghosts are left to the owner of the vector.
  void vector(const std::string& name, Entries entries, Vec x) { exchange(path_ + name, entries, x); }

  /// While it lives, names stand below `name`.
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
