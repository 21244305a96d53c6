#include "raytracer/apps/commands/cluster/batch.hpp"

#include <algorithm>

#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/make/worlds/open/world_kinds.hpp"

namespace terravox::cluster {

namespace fs = std::filesystem;

Batch::Batch(const SlurmOptions& options, ForwardedArguments passed)
    : m_options(options),
      m_passed(std::move(passed)),
      m_folder(options,
               fs::path(m_passed.animation.empty() ? m_passed.outputs.front() : m_passed.animation)
                   .stem()
                   .string()) {
    if (!options.dry_run)
        m_slurm.emplace();
    if (options.needs.cpus > 0 && !m_passed.base_scene().processing.threads)
        m_passed.words.insert(m_passed.words.end(),
                              {"--threads", std::to_string(options.needs.cpus)});
    find_squares();
}

int Batch::array_limit() const {
    constexpr int kAsSlurmComes = 1001;
    return m_slurm ? m_slurm->array_limit() : kAsSlurmComes;
}

Command Batch::command(const std::string& name) const {
    Command out{m_folder.place().program.string()};
    const std::vector<std::string> beginning = words_of_command(name);
    out.insert(out.end(), beginning.begin(), beginning.end());
    out.insert(out.end(), m_passed.words.begin(), m_passed.words.end());
    return out;
}

std::string Batch::submit_tasks(Submission& submission, const std::string& name,
                                const std::vector<int>& tasks) const {
    std::vector<std::string> wait = submit_bake(submission);
    std::string all;
    for (const ArrayPiece& piece : array_pieces(tasks, array_limit())) {
        std::vector<std::string> options{"--array=" + array_text(piece.indices) + "%" +
                                         std::to_string(m_options.nodes)};
        options.insert(options.end(), wait.begin(), wait.end());
        const Slurm::JobId job = submission.submit(
            name, options, static_cast<int>(piece.indices.size()), {std::to_string(piece.offset)});
        all += ":" + job;
        wait = {"--dependency=afterany:" + job};  // one array after another: --nodes applies to all
    }
    return all;
}

/// LiDAR squares are prepared once, into a cache folder that all nodes share; other worlds need no
/// preparation.
void Batch::find_squares() {
    const worlds::WorldKind& kind = worlds::kind_of(m_passed.world.inputs.front());
    if (!kind.has_squares || m_passed.world.cache == "none")
        return;
    if (m_passed.world.cache.empty()) {
        m_passed.world.cache = (m_folder.path() / "cache").string();
        m_passed.words.insert(m_passed.words.end(), {"--cache", m_passed.world.cache});
    }
    if (!m_options.bake)
        return;
    constexpr int kTasksOfNode = 4;
    m_bake_tasks = m_options.nodes * kTasksOfNode;
    if (&kind == &worlds::kLidarKind)
        m_bake_tasks =
            std::min(m_bake_tasks,
                     static_cast<int>(pointcloud::expand_point_files({m_passed.world.inputs.begin(),
                                                                      m_passed.world.inputs.end()})
                                          .size()));
}

/// @return an option of sbatch that lets a job wait for the squares; none when there is nothing to
/// prepare
std::vector<std::string> Batch::submit_bake(Submission& submission) const {
    if (m_bake_tasks == 0)
        return {};
    const int tasks = std::min(m_bake_tasks, array_limit());
    m_folder.write_script("bake.sbatch",
                          bake_script(m_folder.place(), m_passed.command, m_passed.words, tasks));
    // afterany: squares that could not be prepared are reported by the frames that need them.
    return {"--dependency=afterany:" + submission.submit("bake",
                                                         {"--array=0-" + std::to_string(tasks - 1) +
                                                          "%" + std::to_string(m_options.nodes)},
                                                         tasks)};
}

util::ExitCode run_batch(const SlurmOptions& options, const std::vector<std::string>& words) {
    if (options.parts > 0) {
        const std::string& command = options.analyse.empty() ? "render" : options.analyse;
        ForwardedArguments passed = ForwardedArguments::read(command, words);
        for (const char* own : {"--part", "--resume", "--listen", "--worker", "--json"})
            if (passed.has(own))
                throw util::UsageError(std::string("cluster slurm --parts: ") + own +
                                       " among the arguments of " + command +
                                       "; allowed: without it, each part "
                                       "renders by itself");
        return run_parts(options, std::move(passed));
    }
    ForwardedArguments passed = ForwardedArguments::read("animate", words);
    for (const char* own : {"--first", "--last", "--every", "--again", "--list"})
        if (passed.has(own))
            throw util::UsageError(
                std::string("cluster slurm --batch: ") + own +
                " among the arguments of animate; allowed: --frames of cluster slurm, "
                "before the animation");
    return run_frames(options, std::move(passed));
}

}  // namespace terravox::cluster
