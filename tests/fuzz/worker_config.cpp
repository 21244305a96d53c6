// The configuration of a worker.
#include "raytracer/farm/worker/worker_config.hpp"

#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {

void run(Input input) {
    farm::WorkerArguments arguments;
    arguments.file = as_file(input, "worker.toml");
    const farm::WorkerConfig config = farm::load_worker_config(arguments);
    expect(difference(config, farm::load_worker_config(arguments)).now.empty(),
           "a file says the same each time it is read");
}

}  // namespace terravox::fuzz
