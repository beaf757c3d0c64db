#include "experiments/sweep/slurm.h"

#include "experiments/process/program.h"
#include "experiments/process/shell_word.h"
#include "experiments/sweep/sweep_file.h"
#include "experiments/sweep/text_file.h"

namespace romano::experiments {
namespace {

namespace fs = std::filesystem;

fs::path shards_of(const SlurmJobs& jobs) {
    fs::path shards = jobs.output;
    shards += "-shards";
    return shards;
}

/// The number of the job.
std::string hand_in(const std::vector<std::string>& arguments) {
    // sbatch says what is wrong on its standard error.
    std::vector<std::string> words = {"-c", "exec sbatch --parsable \"$@\" 2>&1", "sbatch"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const ProgramEnd end = run_program("/bin/sh", words);
    const std::string said = end.output.substr(0, end.output.find('\n'));
    if (end.exit_code == 127) {
        throw SweepError("--slurm: there is no sbatch here; run this where jobs are submitted");
    }
    if (!end.ok()) throw SweepError("--slurm: sbatch refused: " + said);
    return said.substr(0, said.find(';'));  // "JOB;CLUSTER" where there are several clusters
}

}  // namespace

std::string array_script(const SlurmJobs& jobs) {
    const std::string count = std::to_string(jobs.shards);
    std::string script = "#!/bin/sh\n# The shards of " + jobs.file.string() +
                         ": one that ended early is started again, and goes on where it was.\n"
                         "#SBATCH --job-name=romano-sweep\n#SBATCH --requeue\n"
                         "# Figures of time want a machine of their own.\n#SBATCH --exclusive\n"
                         "#SBATCH --array=1-" +
                         count +
                         "\n#SBATCH --output=" + (shards_of(jobs) / "slurm-%a.txt").string() +
                         "\n#SBATCH --open-mode=append\n";
    for (const std::string& option : jobs.options) script += "#SBATCH " + option + "\n";
    return script + "exec " + shell_word(jobs.program.string()) + " sweep " +
           shell_word(jobs.file.string()) + " --broker " +
           shell_word(jobs.broker_program.string()) +
           " --retry-failed --shard \"$SLURM_ARRAY_TASK_ID/" + count + "\"\n";
}

std::string merge_script(const SlurmJobs& jobs) {
    const fs::path shards = shards_of(jobs);
    return "#!/bin/sh\n#SBATCH --job-name=romano-merge\n#SBATCH --output=" +
           (shards / "slurm-merge.txt").string() + "\nexec " + shell_word(jobs.program.string()) +
           " merge " + shell_word(jobs.output.string()) + " " + shell_word(shards.string()) +
           "/*-of-*\n";
}

std::string submit(const SlurmJobs& jobs) {
    const fs::path shards = shards_of(jobs);
    make_folder(shards);
    write_text(shards / "array.sh", array_script(jobs));
    write_text(shards / "merge.sh", merge_script(jobs));
    const std::string array = hand_in({(shards / "array.sh").string()});
    // Whatever became of the shards: what there is makes a report, which tells what is missing.
    const std::string merge =
        hand_in({"--dependency=afterany:" + array, (shards / "merge.sh").string()});
    return "Job " + array + ": " + std::to_string(jobs.shards) +
           " shards; what each says: " + (shards / "slurm-*.txt").string() + "\nJob " + merge +
           ": when they have ended, the report: " + (jobs.output / "report.html").string() +
           "\nThe same command again runs what is missing or failed, and nothing twice.\n";
}

}  // namespace romano::experiments
