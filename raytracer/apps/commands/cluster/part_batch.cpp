#include <numeric>

#include "raytracer/apps/commands/cluster/batch.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"

namespace terravox::cluster {
namespace {

namespace fs = std::filesystem;

/// Parts of one picture.
class PartBatch : Batch {
public:
    PartBatch(const SlurmOptions& options, ForwardedArguments passed)
        : Batch(options, std::move(passed)) {}

    util::ExitCode run() {
        const std::vector<std::string> outputs = m_passed.outputs;
        m_passed.take({"-o", "--output"});
        Command joining = m_passed.take_of_whole_raster();
        for (const std::string& output : outputs)
            joining.insert(joining.end(), {"-o", output});
        auto again = m_passed.words;
        again.insert(again.end(), {"-o", outputs.front()});
        if (const ForwardedArguments read = ForwardedArguments::read(m_passed.command, again);
            read.outputs.size() != 1 || read.world.inputs != m_passed.world.inputs)
            throw util::UsageError(
                "cluster slurm --parts: the pictures cannot be distinguished from the other "
                "arguments; "
                "allowed: -o NAME for each, as words of their own");
        scene::Scene scene = m_passed.base_scene();
        // Checkpoints have no coarse passes, whatever the scene specifies.
        scene.quality.coarse_step = 1;
        farm::check_can_checkpoint(scene);
        // The parts' files of tiles are in the job's folder, not next to the picture.
        const fs::path picture = m_folder.path() / "parts" / fs::path(outputs.front()).filename();
        m_passed.words.insert(m_passed.words.end(), {"-o", picture.string()});
        Submission submission(m_options, m_folder, slurm());
        submission.wait_for_earlier();
        m_folder.write_script(
            "parts.sbatch",
            parts_script(m_folder.place(), command(m_passed.command), m_options.parts));
        m_folder.write_script("merge.sbatch", merge_parts_script(m_folder.place(), joining,
                                                                 m_options.parts, picture));

        std::vector<int> tasks(static_cast<std::size_t>(m_options.parts));
        std::iota(tasks.begin(), tasks.end(), 0);
        const std::string all = submit_tasks(submission, "parts", tasks);
        // afterany: merging itself detects missing tiles, and a part with holes is no failure.
        const Slurm::JobId merging = submission.submit("merge", {"--dependency=afterany" + all}, 1);
        if (m_options.dry_run || !m_options.wait)
            return util::ExitCode::kDone;
        submission.follow();
        const auto code = slurm()->exit_code(merging);
        if (!code)
            throw util::Error(
                kBatchAttempt +
                std::string("Slurm no longer reports how the parts were joined; see ") + logs() +
                "/merge-" + merging + ".txt");
        if (*code == static_cast<int>(util::ExitCode::kHoles))
            return util::ExitCode::kHoles;
        if (*code != 0)
            throw util::Error(kBatchAttempt + std::string("the parts were not joined; see ") +
                              logs() + "; the same command continues");
        return util::ExitCode::kDone;
    }
};

}  // namespace

util::ExitCode run_parts(const SlurmOptions& options, ForwardedArguments passed) {
    return PartBatch(options, std::move(passed)).run();
}

}  // namespace terravox::cluster
