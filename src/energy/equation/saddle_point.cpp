#include "energy/equation/saddle_point.hpp"

#include "petsc/check.hpp"

namespace pliant {
namespace {

constexpr const char *of_displacements = "pliant_displacements", *of_pressures = "pliant_pressures",
                     *of_schur = "pliant_schur";

template <class T>
PetscObject object(T of) {
  return reinterpret_cast<PetscObject>(of);
}

template <class T>
T queried(Mat A, const char* name) {
  PetscObject found = nullptr;
  check(PetscObjectQuery(object(A), name, &found));
  return reinterpret_cast<T>(found);
}

}  // namespace

void attach(Mat A, const SaddlePointParts& parts) {
  check(PetscObjectCompose(object(A), of_displacements, object(parts.displacements)));
  check(PetscObjectCompose(object(A), of_pressures, object(parts.pressures)));
  check(PetscObjectCompose(object(A), of_schur, object(parts.schur)));
}

std::optional<SaddlePointParts> saddle_point_of(Mat A) {
  const SaddlePointParts parts{queried<IS>(A, of_displacements), queried<IS>(A, of_pressures),
                               queried<Mat>(A, of_schur)};
  if (parts.displacements == nullptr) return std::nullopt;
  return parts;
}

}  // namespace pliant
