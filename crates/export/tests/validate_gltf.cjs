// Has Khronos' validator look at glTF files, and tells everything that it says of them, but for what it says of an extension that it does not know:
// that it does not know it, and that nobody it knows of uses the numbers that the extension uses.
//
// Usage: node validate_gltf.cjs MODULE FILE…

const fs = require("fs");

const [module_, ...files] = process.argv.slice(2);
const validator = require(module_);
const extension = ["UNSUPPORTED_EXTENSION", "UNUSED_OBJECT"];

async function main() {
    for (const file of files) {
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 0 });
        const instanced = (report.info.extensionsUsed ?? []).includes("EXT_mesh_gpu_instancing");
        const known = (issue) => instanced && issue.severity >= 2 && extension.includes(issue.code);
        const issues = report.issues.messages.filter((issue) => !known(issue));
        for (const issue of issues.slice(0, 20)) {
            console.error(`${issue.severity} ${issue.code} ${issue.pointer}: ${issue.message}`);
        }
        if (issues.length > 0 || report.issues.truncated) process.exit(1);
        const { drawCallCount, animationCount, totalTriangleCount } = report.info;
        console.log(`valid: ${drawCallCount} draws, ${animationCount} animations, ${totalTriangleCount} triangles`);
    }
}

main();
