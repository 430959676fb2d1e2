//! Any number of answers to each question, in two columns.

use rayon::prelude::*;

/// A list of answers to each question of a batch, one behind the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Lists<T> {
    starts: Vec<usize>,
    items: Vec<T>,
}

impl<T> Lists<T> {
    /// Number of questions.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether nothing was asked.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The answers to question `i`; none where there is no such question.
    pub fn get(&self, i: usize) -> &[T] {
        match self.starts.get(i..) {
            Some(&[from, until, ..]) => &self.items[from..until],
            _ => &[],
        }
    }

    /// The answers to one question after the other.
    pub fn iter(&self) -> impl Iterator<Item = &[T]> {
        self.starts.windows(2).map(|ends| &self.items[ends[0]..ends[1]])
    }

    /// All answers, in the order of the questions.
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Where the answers to each question start in [`Lists::items`], and the end of the last.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }
}

impl<T: Send> Lists<T> {
    /// Answers questions in blocks, in parallel; `answer` appends to the list.
    pub(super) fn of<Q: Sync>(questions: &[Q], answer: impl Fn(&Q, &mut Vec<T>) + Sync) -> Self {
        let blocks: Vec<(Vec<usize>, Vec<T>)> = questions
            .par_chunks(super::BLOCK)
            .map(|block| {
                let mut items = Vec::new();
                let counts = block.iter().map(|question| {
                    let before = items.len();
                    answer(question, &mut items);
                    items.len() - before
                });
                (counts.collect(), items)
            })
            .collect();
        let mut lists = Lists {
            starts: Vec::with_capacity(questions.len() + 1),
            items: Vec::with_capacity(blocks.iter().map(|(_, items)| items.len()).sum()),
        };
        let mut end = 0;
        lists.starts.push(end);
        for (counts, items) in blocks {
            lists.starts.extend(counts.into_iter().map(|count| {
                end += count;
                end
            }));
            lists.items.extend(items);
        }
        lists
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_question_has_its_own_answers() {
        let questions: Vec<usize> = (0..1000).map(|i| i * 7 % 5).collect();
        let lists = Lists::of(&questions, |&count, out| out.extend((0..count).map(|k| 10 * count + k)));
        assert_eq!((lists.len(), lists.starts().len()), (1000, 1001));
        for (i, list) in lists.iter().enumerate() {
            let count = questions[i];
            assert_eq!(list, (0..count).map(|k| 10 * count + k).collect::<Vec<_>>());
            assert_eq!(list, lists.get(i));
        }
        assert_eq!(lists.get(1000), [0_usize; 0]);
        assert!(Lists::<u8>::of(&[] as &[u8], |_, _| ()).is_empty());
    }
}
