#include "tests/bench/entries/embree_scene.hpp"

namespace terravox::bench {

std::unique_ptr<EmbreeScene> make_embree_scene(const NeutralScene&, int) {
    return nullptr;
}

}  // namespace terravox::bench
