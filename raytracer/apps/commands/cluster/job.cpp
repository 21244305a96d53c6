#include "raytracer/apps/commands/cluster/job.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "common/util/atomic_file.hpp"
#include "common/util/folders.hpp"

namespace terravox::cluster {

namespace fs = std::filesystem;

JobFolder::JobFolder(const SlurmOptions& options, const std::string& picture)
    : m_path(fs::absolute(options.folder.empty() ? fs::path("jobs") / picture : options.folder)) {
    m_path = m_path.lexically_normal();
    if (!m_path.has_filename())
        m_path = m_path.parent_path();  // "a/" is "a"
    // Slurm reads % and \\ in the folder of a job as a pattern for the names of logs, and then
    // finds no logs/.
    if (m_path.string().find_first_of("%\\") != std::string::npos)
        throw util::UsageError(
            "cluster: the job's folder " + m_path.string() +
            "; allowed: a path without % and \\, which Slurm takes for patterns (--folder)");
    options.needs.check();
    m_place.needs = options.needs;
    m_place.work = fs::current_path();
    m_place.program = options.program.empty() ? util::beside_program("terravox-raytracer")
                                              : fs::absolute(options.program);
    std::error_code failed;
    fs::create_directories(m_path / "logs", failed);
    if (failed)
        throw util::Error("make the folder of the job " + m_path.string() + ": " +
                          failed.message());
}

void JobFolder::write_script(const std::string& name, const std::string& text) const {
    util::write_file_atomically(m_path / name, text);
}

void JobFolder::write_secret(const std::string& name, const std::string& text) const {
    const fs::path file = m_path / name;
    const auto fail = [&](int code) {
        throw util::Error("write " + file.string() + ": " + std::strerror(code));
    };
    if (::unlink(file.c_str()) != 0 && errno != ENOENT)
        fail(errno);
    // Never readable by others, not even for a moment.
    const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (fd < 0)
        fail(errno);
    const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    const int code = written ? 0 : errno;
    if (::close(fd) != 0 || !written)
        fail(code != 0 ? code : errno);
}

void QueueReporter::report(const Slurm::Counts& counts) {
    if (m_quiet || (m_reported && counts == m_last))
        return;
    m_reported = true;
    m_last = counts;
    // Overwrites the bar that the render may be drawing; it draws a new one below.
    std::fprintf(stderr, "%sslurm: %d of %d tasks run, %d wait\n",
                 ::isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "", counts.running, m_tasks,
                 counts.waiting);
}

}  // namespace terravox::cluster
