// For fuzzers of what may crash in a process of its own: a child per case would be slow, and the code it reaches
// unseen.
#include "mesh/isolated.hpp"

namespace pliant {

SerialMesh isolated(Suspect /*suspect*/, const std::function<SerialMesh()>& work) {
  return work();
}

}  // namespace pliant
